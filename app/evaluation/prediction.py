"""Predictions for evaluation: a run folder, or another system's files."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Literal

import numpy as np

from app.run_folder import run_folder as names
from app.settings.config_file import read_run_config
from data_tools.predictions.submission import find_submission, read_submission
from data_tools.predictions.vertex_labels import SUFFIXES, read_vertex_labels
from data_tools.recordings.trajectories import read_trajectory
from razer.arrays import FloatArray, IntArray
from razer.errors import BadInput
from razer.metrics.scene_pair import PredictedScene, TimedPoses
from razer.models import NameTable, TextSide, make_embedder
from razer.plugins import NO_TRUST, Trust
from razer.storage import read_mesh_ply
from razer.vocabulary import vocabulary

Naming = Literal["auto", "run", "text"]
LabelMeaning = Literal["instance", "class"]


def is_run(path: Path) -> bool:
    """Whether a folder is one that `razer run` wrote."""
    return (path / names.INSTANCES).is_file() and (path / names.MESH_PLY).is_file()


def read_prediction(
    path: Path,
    class_names: Mapping[int, str],
    n_vertices: int,
    *,
    naming: Naming = "auto",
    template: str = "{}",
    scene: str | None = None,
    labels: LabelMeaning = "instance",
    trust: Trust = NO_TRUST,
) -> PredictedScene:
    """The prediction in a run folder, a submission to the ScanNet benchmark, or a file of vertex labels.

    Args:
        path: the folder or file.
        class_names: the truth's class names by number: the candidates when instances are classified by text, and what
            a file's class numbers mean where they are not ScanNet200's.
        n_vertices: number of vertices of the truth.
        naming: where a run's instances get their classes: from the run, by text, or by text if the run has none.
        template: text prompt with {} for the class name.
        scene: which scene, where a folder holds several.
        labels: what numbers below 1000 in a file of vertex labels are.
        trust: which outside code may be loaded for the run's embedder.

    Raises:
        BadInput: naming what is missing, unknown or does not fit the truth.
    """
    if not path.exists():
        raise BadInput(f"{path} does not exist: give a run folder, a submission or a file of vertex labels")
    if is_run(path):
        return _of_run(path, sorted(set(class_names.values())), naming, template, trust)
    if submission := find_submission(path, scene):
        return _of_submission(submission, class_names, n_vertices)
    if path.is_file() and path.suffix in SUFFIXES:
        return _of_labels(path, class_names, labels)
    raise BadInput(
        f"{path} is no run folder (no {names.INSTANCES}), no list of `mask_file class confidence`, and no file of "
        f"vertex labels ({', '.join(SUFFIXES)})"
    )


def _of_run(folder: Path, class_names: Sequence[str], naming: Naming, template: str, trust: Trust) -> PredictedScene:
    mesh = read_mesh_ply(folder / names.MESH_PLY)
    instances = json.loads((folder / names.INSTANCES).read_text())["instances"]
    own = {int(i["id"]): str(i["class"]) for i in instances if i["class"]}
    by_text = None if naming == "run" or (naming == "auto" and own) else _by_text(folder, class_names, template, trust)
    if naming == "text" and by_text is None:
        raise BadInput(f"--names text: the embedder of {folder} has no text side; use --names run")
    return PredictedScene(
        vertices=mesh.vertices,
        instances=mesh.instances,
        triangles=mesh.triangles,
        scores={int(i["id"]): float(i["score"]) for i in instances},
        class_names=own if by_text is None else by_text,
        trajectory=_trajectory(folder / names.TRAJECTORY),
        own_frame=_estimated_poses(folder / names.CONFIG),
    )


def _estimated_poses(config: Path) -> bool:
    """Whether a run estimated its poses, and so lies in a frame of its own."""
    return config.exists() and read_run_config(config).input.poses == "slam"


def _by_text(folder: Path, class_names: Sequence[str], template: str, trust: Trust) -> dict[int, str] | None:
    """The class whose text is nearest to any of an instance's embeddings; None where the embedder knows no text."""
    config = read_run_config(folder / names.CONFIG, trust=trust)
    embedder = make_embedder(config.embedder.name, config.embedder.options, config.embedder.trust)
    if not isinstance(embedder, TextSide):
        return None
    texts = class_names if isinstance(embedder, NameTable) else [template.format(name) for name in class_names]
    with np.load(folder / names.EMBEDDINGS) as bank:
        return nearest_names(bank["ids"], bank["embeddings"], class_names, embedder.embed_texts(texts))


def nearest_names(
    ids: IntArray, embeddings: FloatArray, class_names: Sequence[str], texts: FloatArray
) -> dict[int, str]:
    """For each id the class name whose text embedding has the largest cosine with any of the id's embeddings.

    Args:
        ids: (R,) the instance of each row of `embeddings`.
        embeddings: (R, D) unit vectors, a row for each embedding cluster of an instance.
        class_names: N names.
        texts: (N, D) their unit text embeddings.
    """
    if len(ids) == 0:  # the embeddings then have no width either
        return {}
    cosine = embeddings @ texts.T
    return {int(i): class_names[int(cosine[ids == i].max(axis=0).argmax())] for i in np.unique(ids)}


def _trajectory(path: Path) -> TimedPoses | None:
    return timed_poses(path) if path.is_file() else None


def timed_poses(path: Path) -> TimedPoses:
    """The poses of a TUM file; those at one and the same time count once. Raises BadInput, also for none at all."""
    trajectory = read_trajectory(path)
    if not len(trajectory.stamps):
        raise BadInput(f"{path} holds no pose")
    stamps, first = np.unique(trajectory.stamps, return_index=True)
    return TimedPoses(stamps, np.stack([trajectory.nearest(float(s))[0] for s in trajectory.stamps[first]]))


def _of_submission(path: Path, class_names: Mapping[int, str], n_vertices: int) -> PredictedScene:
    submission = read_submission(path)
    if submission.masks and submission.n_vertices != n_vertices:
        raise BadInput(
            f"the masks of {path} have {submission.n_vertices} lines, but the truth has {n_vertices} vertices"
        )
    named = {i: name for i, label in submission.labels.items() if (name := _name_of(label, class_names))}
    return PredictedScene(masks=submission.masks, scores=submission.scores, class_names=named)


def _of_labels(path: Path, class_names: Mapping[int, str], meaning: LabelMeaning) -> PredictedScene:
    labels = read_vertex_labels(path)
    if labels.classes is None and meaning == "class":
        numbers = np.unique(labels.instances).tolist()
        named = {n: name for n in numbers if n and (name := _name_of(n, class_names))}
        return PredictedScene(classes=labels.instances, vertex_class_names=named)
    if labels.classes is None:
        return PredictedScene(instances=labels.instances)
    known = dict(labels.class_names)
    for number in np.unique(labels.classes).tolist():
        if number and number not in known and (name := _name_of(number, class_names)):
            known[number] = name
    ids, first = np.unique(labels.instances, return_index=True)
    of_instance = {
        int(i): known[c]
        for i, c in zip(ids.tolist(), labels.classes[first].tolist(), strict=True)
        if i > 0 and c in known
    }
    return PredictedScene(
        instances=labels.instances, class_names=of_instance, classes=labels.classes, vertex_class_names=known
    )


def _name_of(number: int, class_names: Mapping[int, str]) -> str | None:
    """The name of a class number: the truth's, or else ScanNet200's."""
    category = vocabulary("scannet200").by_id.get(number)
    return class_names.get(number) or (category.name if category else None)
