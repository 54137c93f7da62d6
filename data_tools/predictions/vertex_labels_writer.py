"""Writers of instances as one label for each vertex of the ground-truth mesh, as a mesh or as texts."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

import numpy as np

from data_tools.predictions.vertex_labels import CONFIDENCE, CONFIDENCES, INSTANCES
from data_tools.truth.ply_writer import write_ply
from razer.arrays import FloatArray, Int64Array, IntArray


def write_labelled_mesh(
    path: Path,
    vertices: FloatArray,
    triangles: IntArray | None,
    instances: Int64Array,
    labels: Mapping[int, int],
    scores: Mapping[int, float],
) -> None:
    """Write a .ply with the vertex properties instance, class and confidence (64 bits).

    Args:
        path: the file.
        vertices: (V, 3) of the truth, metres.
        triangles: (T, 3) of the truth; None = none.
        instances: (V,), 0 for nobody.
        labels: class number by instance, 0 where there is none.
        scores: confidence by instance, 1 where there is none.
    """
    path.parent.mkdir(parents=True, exist_ok=True)
    ids, where = np.unique(instances, return_inverse=True)
    of_class = np.array([labels.get(i, 0) for i in ids.tolist()], "<i4")
    confidence = np.array([float(scores.get(i, 1.0)) if i else 0.0 for i in ids.tolist()], "<f8")
    columns = {"instance": instances.astype("<i4"), "class": of_class[where], CONFIDENCE: confidence[where]}
    faces = np.empty((0, 3), np.int32) if triangles is None else np.asarray(triangles, np.int32)
    write_ply(path, np.asarray(vertices, np.float32), columns, faces)


def write_label_texts(
    folder: Path,
    scene: str,
    instances: Int64Array,
    classes: Int64Array,
    labels: Mapping[int, int],
    scores: Mapping[int, float],
) -> None:
    """Write scene.txt with the class of each vertex, scene_instances.txt with its instance, and scene_confidences.txt
    with lines of `instance class confidence`.

    Args:
        folder: where to; it is made if need be.
        scene: how the files are called.
        instances: (V,), 0 for nobody.
        classes: (V,) class numbers, 0 for none.
        labels: class number by instance, 0 where there is none.
        scores: confidence by instance, 1 where there is none.
    """
    folder.mkdir(parents=True, exist_ok=True)
    numbers = [i for i in np.unique(instances).tolist() if i > 0]
    rows = [f"{i} {labels.get(i, 0)} {float(scores.get(i, 1.0))!r}\n" for i in numbers]
    (folder / CONFIDENCES.format(scene)).write_text("".join(rows))
    (folder / INSTANCES.format(scene)).write_text(_lines(instances))
    (folder / f"{scene}.txt").write_text(_lines(classes))


def _lines(numbers: Int64Array) -> str:
    return "".join(f"{number}\n" for number in numbers.tolist())
