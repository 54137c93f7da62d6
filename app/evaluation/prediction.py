"""Predictions for evaluation: a run folder, or another system's files."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Literal

import numpy as np

from app.console.streams import print_notes
from app.evaluation.class_numbers import ClassNumbers
from app.query.queryable_map import open_map
from app.run_folder import run_folder as names
from app.run_folder.timed_poses import run_poses
from data_tools.predictions.submission import find_submission, read_submission
from data_tools.predictions.vertex_labels import SUFFIXES, read_vertex_labels
from razer.errors import BadInput
from razer.files import plain_os_errors
from razer.metrics.scene_pair import PredictedScene
from razer.models import TextEncoder
from razer.panoptic_map import PanopticMap
from razer.plugins import NO_TRUST, Trust
from razer.query.text_queries import TextQueryEncoder
from razer.semantics.labelling import known_names, probable_names
from razer.storage.file_names import is_map_folder

Naming = Literal["auto", "run", "text"]
LabelMeaning = Literal["instance", "class"]


def read_prediction(
    path: Path,
    class_names: Mapping[int, str],
    n_vertices: int,
    *,
    numbers: ClassNumbers | None = None,
    naming: Naming = "auto",
    template: str | None = None,
    scene: str | None = None,
    labels: LabelMeaning = "instance",
    trust: Trust = NO_TRUST,
) -> PredictedScene:
    """The prediction in a run folder, a submission to the ScanNet benchmark, or a file of vertex labels.

    Args:
        path: the folder or file.
        class_names: the truth's class names by number: the candidates when instances are classified by text.
        n_vertices: number of vertices of the truth.
        numbers: what class numbers in files mean; None = as in class_names.
        naming: where a run's instances get their classes: from the run, by text, or by text if the run has none.
        template: text prompt with {} for the class name; None: the prompts of `razer query`.
        scene: which scene, where a folder holds several.
        labels: what numbers below 1000 in a file of vertex labels are.
        trust: which outside code may be loaded for the run's embedder.

    Raises:
        BadInput: naming what is missing, unknown or does not fit the truth.
    """
    numbers = numbers or ClassNumbers(class_names, "the truth's own classes")
    with plain_os_errors(path):
        is_there = path.exists()
    if not is_there:
        raise BadInput(f"{path} does not exist: give a run folder, a submission or a file of vertex labels")
    if is_map_folder(path):
        return _of_run(path, sorted(set(class_names.values())), naming, template, trust)
    if submission := find_submission(path, scene):
        return _of_submission(submission, numbers, n_vertices)
    if path.is_file() and path.suffix in SUFFIXES:
        return _of_labels(path, numbers, labels)
    raise BadInput(
        f"{path} is no run folder (no {names.INSTANCES}), no list of `mask_file class confidence`, and no file of "
        f"vertex labels ({', '.join(SUFFIXES)})"
    )


def _of_run(
    folder: Path, class_names: Sequence[str], naming: Naming, template: str | None, trust: Trust
) -> PredictedScene:
    panoptic, config = open_map(folder, trust=trust)
    own = {o.id: o.class_name for o in panoptic.objects if o.class_name}
    # Structure bears names where nothing else does, and so does what people named: they say nothing about other things.
    has_named_things = any(o.class_name and not o.is_stuff and not o.is_named_by_hand for o in panoptic.objects)
    needs_text = naming == "text" or (naming == "auto" and not has_named_things)
    named = _by_text(panoptic, class_names, template) if needs_text else None
    by_text = None if named is None else {i: name for i, (name, _) in named.items()}
    if naming == "text" and by_text is None:
        raise BadInput(f"--names text: the embedder of {folder} has no text encoder; use --names run")
    return PredictedScene(
        vertices=panoptic.mesh.vertices,
        instances=panoptic.mesh.instances,
        triangles=panoptic.mesh.triangles,
        scores={o.id: o.score for o in panoptic.objects},
        class_names=own if by_text is None else by_text if naming == "text" else by_text | own,
        name_probabilities={
            i: probability for i, (_, probability) in (named or {}).items() if naming == "text" or i not in own
        },
        trajectory=None if (own_poses := run_poses(folder)) is None else own_poses[0],
        own_frame=config.input.poses == "slam" or config.input.poses_from is not None,
    )


def _by_text(
    panoptic: PanopticMap, class_names: Sequence[str], template: str | None
) -> dict[int, tuple[str, float]] | None:
    """The class that `razer label` would choose among those of the truth, and its probability, by instance; None where
    the embedder knows no text. template: the only prompt, instead of those of `razer query`."""
    assert panoptic.text_queries is not None
    embedder = panoptic.text_queries.embedder
    if not isinstance(embedder, TextEncoder):
        return None
    if template is not None:
        panoptic = replace(panoptic, text_queries=TextQueryEncoder(embedder, templates=(template,)))
    known = known_names(panoptic, class_names, "of the truth")
    if n_unknown := len(class_names) - len(known):
        print_notes([f"the embedder does not know {n_unknown} of the truth's {len(class_names)} names: left out"])
    return probable_names(panoptic, known)


def _of_submission(path: Path, numbers: ClassNumbers, n_vertices: int) -> PredictedScene:
    submission = read_submission(path)
    if submission.masks and submission.n_vertices != n_vertices:
        raise BadInput(
            f"the masks of {path} have {submission.n_vertices} lines, but the truth has {n_vertices} vertices"
        )
    known = numbers.named(submission.labels.values(), path)
    named = {i: known[label] for i, label in submission.labels.items() if label in known}
    return PredictedScene(masks=submission.masks, scores=submission.scores, class_names=named)


def _of_labels(path: Path, numbers: ClassNumbers, meaning: LabelMeaning) -> PredictedScene:
    labels = read_vertex_labels(path)
    if labels.classes is None and meaning == "class":
        named = numbers.named(np.unique(labels.instances).tolist(), path)
        return PredictedScene(classes=labels.instances, vertex_class_names=named)
    if labels.classes is None:
        return PredictedScene(instances=labels.instances, scores=labels.scores)
    of_instances = labels.classes_of_instances()
    used = {*np.unique(labels.classes).tolist(), *of_instances.values()}
    others = used - labels.class_names.keys()
    known = {**labels.class_names, **numbers.named(others, path)}
    return PredictedScene(
        instances=labels.instances,
        scores=labels.scores,
        # An instance that the file gives no class has none, whatever class vertices around it lend to its own.
        class_names={i: known.get(of_instances.get(i, 0), "") for i in np.unique(labels.instances).tolist() if i > 0},
        classes=labels.classes,
        vertex_class_names=known,
    )
