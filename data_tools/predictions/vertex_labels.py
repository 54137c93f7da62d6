"""Predicted instances as one label for each vertex of the ground-truth mesh."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from data_tools.truth.ply import read_ply
from razer.arrays import Int64Array
from razer.errors import BadInput
from razer.files import MALFORMED, MAX_TEXT_BYTES, read_bytes, read_json, read_lines, read_npy

_CLASS = 1000  # class * 1000 + instance is how ScanNet's scripts write both in one number
SUFFIXES = (".txt", ".npy", ".ply")
INSTANCES, CONFIDENCES = "{}_instances.txt", "{}_confidences.txt"
CONFIDENCE = "confidence"


@dataclass(frozen=True, slots=True)
class VertexLabels:
    """instances (V,) with 0 for nobody; classes (V,) class numbers with 0 for none, or None where the file says
    nothing of them; class_names: the names of class numbers, where a file beside it has them; scores: confidences of
    instances, where they are there; instance_classes: class numbers of instances, 0 for none, where they are written
    apart from those of the vertices."""

    instances: Int64Array
    classes: Int64Array | None = None
    class_names: Mapping[int, str] = field(default_factory=dict)
    scores: Mapping[int, float] = field(default_factory=dict)
    instance_classes: Mapping[int, int] | None = None

    def classes_of_instances(self) -> Mapping[int, int]:
        """The class number of each instance: where they are not written apart, that of its first vertex if it has
        one."""
        if self.instance_classes is not None or self.classes is None:
            return self.instance_classes or {}
        ids, first = np.unique(self.instances, return_index=True)
        return {i: c for i, c in zip(ids.tolist(), self.classes[first].tolist(), strict=True) if i > 0 and c > 0}


def read_vertex_labels(path: Path) -> VertexLabels:
    """Read labels: a .txt with a whole number a line, a .npy (V,), or a .ply with the vertex property `instance`,
    perhaps with `class` and `confidence`, and with a classes.json beside it. Numbers from 1000 on mean
    class * 1000 + instance; where the file of instances is beside it, they are the classes. Raises BadInput."""
    if path.suffix == ".ply":
        return _from_ply(path)
    beside = path.with_name(INSTANCES.format(path.stem))
    if path.suffix == ".txt" and beside.is_file():
        return _with_instances(path, beside)
    numbers = _numbers(path)
    if numbers.max(initial=0) < _CLASS:
        return VertexLabels(numbers)
    return VertexLabels(numbers * (numbers >= _CLASS), numbers // _CLASS)


def _numbers(path: Path) -> Int64Array:
    try:
        numbers = (
            read_npy(path) if path.suffix == ".npy" else np.array(read_bytes(path, MAX_TEXT_BYTES).split(), np.int64)
        )
    except MALFORMED as error:
        raise BadInput(f"{path} must hold one whole number for each vertex (problem: {error})") from None
    if numbers.ndim != 1 or not np.issubdtype(numbers.dtype, np.integer):
        raise BadInput(f"{path} holds {numbers.dtype} of shape {numbers.shape}: whole numbers (V,) are needed")
    return numbers.astype(np.int64).clip(0)


def _with_instances(path: Path, beside: Path) -> VertexLabels:
    """Classes, instances and confidences in a file each."""
    classes, instances = _numbers(path), _numbers(beside)
    if len(classes) != len(instances):
        raise BadInput(f"{beside} has {len(instances)} lines, but {path.name} {len(classes)}: one for each vertex")
    file = path.with_name(CONFIDENCES.format(path.stem))
    try:
        rows = [line.split() for line in read_lines(file) if line.strip()]
        scores = {int(number): float(score) for number, _, score in rows}
        labels = {int(number): int(label) for number, label, _ in rows}
    except MALFORMED as error:
        raise BadInput(f"{file} must hold lines of `instance class confidence` (problem: {error})") from None
    return VertexLabels(instances, classes, {}, scores, labels)


def _from_ply(path: Path) -> VertexLabels:
    vertex = read_ply(path).vertices
    if "instance" not in vertex:
        raise BadInput(f"{path} has no vertex property 'instance' (it has {', '.join(vertex)})")
    instances = vertex["instance"].astype(np.int64).clip(0)
    classes = vertex["class"].astype(np.int64).clip(0) if "class" in vertex else None
    names = path.with_name("classes.json")
    known = _names(names) if names.is_file() else {}
    scores: dict[int, float] = {}
    if CONFIDENCE in vertex:
        ids, first = np.unique(instances, return_index=True)
        scores = dict(zip(ids.tolist(), vertex[CONFIDENCE][first].tolist(), strict=True))
    return VertexLabels(instances, classes, known, scores)


def _names(path: Path) -> dict[int, str]:
    try:
        return {int(number): str(name) for number, name in read_json(path).items()}
    except MALFORMED as error:
        raise BadInput(f"{path} must map class numbers to names (problem: {error})") from None
