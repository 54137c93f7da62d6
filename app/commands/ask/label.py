"""`razer label`: zero-shot classification of a map's instances, panoptic mesh and scene graph."""

from __future__ import annotations

from json import dumps
from pathlib import Path

from app.console.streams import print_notes
from app.settings.options import Assignments, Flag, TrustOptions
from razer.errors import BadInput


def label(
    run: Path,
    /,
    *,
    vocabulary: str,
    embedder: str | None = None,
    set: Assignments = (),
    options: TrustOptions = TrustOptions(),  # noqa: B008
    json: Flag = False,
) -> int:
    """Give each instance the class of a vocabulary that fits it best; stuff of one class is merged into one segment.

    Fills the class in instances.json, and writes panoptic.ply, panoptic.json, scene_graph.json and mesh.glb.

    Parameters
    ----------
    run:
        The folder of a finished run.
    vocabulary:
        scannet200, scannet20, nyu40, replica, coco, lvis, or a file: a .csv with columns id, name and optionally stuff,
        or a text with a name on each line.
    embedder:
        Embedder, a name or module:Class; the one that the run was made with if not given.
    set:
        One setting as section.key=value, such as an option of the embedder; may be repeated.
    json:
        One line of JSON.
    """
    # Late, since these bring Open3D and torch along.
    from app.query.labelled_run import LabelledRun
    from app.query.queryable_map import open_queryable_map
    from razer.semantics.labelling import known_categories
    from razer.semantics.labelling import label as label_map
    from razer.vocabulary import vocabulary as read_vocabulary

    classes = read_vocabulary(vocabulary)
    queryable = open_queryable_map(run, embedder, set, by_text=True, trust=options.trust)
    known = known_categories(queryable.panoptic, classes)
    if n_unknown := len(classes.categories) - len(known):
        print_notes([f"the embedder does not know {n_unknown} of the {len(classes.categories)} names: left out"])
    labelled = LabelledRun.of(queryable, classes.name, label_map(queryable.panoptic, known))
    try:
        labelled.write()
    except OSError as error:
        raise BadInput(f"{run} cannot be written to ({error.strerror}): its older files are as they were") from error
    if json:
        print(dumps(labelled.as_json()))
    else:
        labelled.report()
    return 0
