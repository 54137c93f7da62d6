"""`razer label`: zero-shot classification of a map's instances, panoptic mesh and scene graph."""

from __future__ import annotations

from collections import Counter
from json import dumps
from pathlib import Path
from typing import TYPE_CHECKING

from app.console.outputs import print_next, print_outputs
from app.console.streams import result_console
from app.console.waiting import waiting_for
from app.next_steps import looking_at
from app.settings.options import Assignments, Flag, TrustOptions

if TYPE_CHECKING:
    from app.query.labelled_run import LabelledRun

PICTURE = "labels.png"
OUTPUTS = {
    "instances.json": "each instance with its class",
    "panoptic.ply": "the surface by classes, stuff of one class as one segment",
    "panoptic.json": "its segments: class, score, instances",
    "scene_graph.json": "what is on, in, under and next to what",
    "mesh.glb": "the surface for viewers, a node for each segment",
    PICTURE: "the map by classes",
}


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

    Fills the class in instances.json, and writes panoptic.ply, panoptic.json, scene_graph.json, mesh.glb and, without
    --json, labels.png.

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
    from razer.vocabulary import vocabulary as read_vocabulary

    classes = read_vocabulary(vocabulary)
    with waiting_for("opening the map and naming its instances"):
        from app.query.label_run import label_run  # late, since it brings Open3D and torch along

        labelled = label_run(run, classes, embedder, set, trust=options.trust)
    if json:
        print(dumps(labelled.as_json()))
    else:
        labelled.report()
        _draw(labelled)
        print_outputs(run, OUTPUTS)
        names = Counter(label.category.name for label in labelled.labels)
        # The run's own embedder answers queries, whichever named the instances.
        question = [("query", run, name) for name, _ in names.most_common(1)] if embedder is None and not set else []
        print_next(looking_at(run), *question)
    return 0


def _draw(labelled: LabelledRun) -> None:
    with waiting_for("drawing the map"):
        from app.pictures.picture_file import add_picture
        from app.pictures.scenes import map_scene

        add_picture(labelled.queryable.folder / PICTURE, map_scene(labelled.named(), "class"), result_console())
