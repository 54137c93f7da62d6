"""Predicted instances as one label for each vertex of the ground-truth mesh."""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from data_tools.truth.ply import read_ply
from razer.arrays import Int64Array
from razer.errors import BadInput

_CLASS = 1000  # class * 1000 + instance is how ScanNet's scripts write both in one number
SUFFIXES = (".txt", ".npy", ".ply")


@dataclass(frozen=True, slots=True)
class VertexLabels:
    """instances (V,) with 0 for nobody; classes (V,) class numbers with 0 for none, or None where the file says
    nothing of them; class_names: the names of class numbers, where a file beside it has them."""

    instances: Int64Array
    classes: Int64Array | None = None
    class_names: Mapping[int, str] = field(default_factory=dict)


def read_vertex_labels(path: Path) -> VertexLabels:
    """Read labels: a .txt with a whole number a line, a .npy (V,), or a .ply with the vertex property `instance`,
    perhaps with `class` and with a classes.json beside it. Numbers from 1000 on mean class * 1000 + instance. Raises
    BadInput."""
    if path.suffix == ".ply":
        return _from_ply(path)
    try:
        numbers = np.load(path) if path.suffix == ".npy" else np.array(path.read_bytes().split(), np.int64)
    except (OSError, ValueError, OverflowError) as error:
        raise BadInput(f"{path} must hold one whole number for each vertex (problem: {error})") from None
    if numbers.ndim != 1 or not np.issubdtype(numbers.dtype, np.integer):
        raise BadInput(f"{path} holds {numbers.dtype} of shape {numbers.shape}: whole numbers (V,) are needed")
    numbers = numbers.astype(np.int64).clip(0)
    if numbers.max(initial=0) < _CLASS:
        return VertexLabels(numbers)
    return VertexLabels(numbers * (numbers >= _CLASS), numbers // _CLASS)


def _from_ply(path: Path) -> VertexLabels:
    vertex = read_ply(path).vertices
    if "instance" not in vertex:
        raise BadInput(f"{path} has no vertex property 'instance' (it has {', '.join(vertex)})")
    classes = vertex["class"].astype(np.int64) if "class" in vertex else None
    names = path.with_name("classes.json")
    known = {int(k): str(v) for k, v in json.loads(names.read_text()).items()} if names.is_file() else {}
    return VertexLabels(vertex["instance"].astype(np.int64).clip(0), classes, known)
