"""Predicted instances as submitted to the ScanNet benchmark: mask files with a class and a confidence each."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from razer.arrays import BoolArray, Int64Array
from razer.errors import BadInput


@dataclass(frozen=True, slots=True)
class Submission:
    """masks: vertex numbers (M,) by prediction, numbered from 1 in the order of the file; they may overlap.
    labels and scores: the class number and confidence of each; n_vertices: lines of the mask files."""

    masks: Mapping[int, Int64Array]
    labels: Mapping[int, int]
    scores: Mapping[int, float]
    n_vertices: int


def find_submission(path: Path, scene: str | None) -> Path | None:
    """The list of a scene in a submission folder, or the path itself if it is a list; None where there is none.
    Raises BadInput for several lists without a scene to choose by."""
    if path.is_file():
        return path if path.suffix == ".txt" and _is_list(path) else None
    lists = [file for file in sorted(path.glob("*.txt")) if _is_list(file)]
    if scene is not None:
        lists = [file for file in lists if file.stem == scene]
    if len(lists) > 1:
        raise BadInput(f"{path} holds {len(lists)} scenes: choose one with --scene, such as {lists[0].stem}")
    return lists[0] if lists else None


def read_submission(path: Path) -> Submission:
    """Read a list of `mask_file class confidence`; raises BadInput naming file and line."""
    masks: dict[int, Int64Array] = {}
    labels: dict[int, int] = {}
    scores: dict[int, float] = {}
    length = 0
    numbered = [(n, line) for n, line in enumerate(path.read_text().splitlines(), start=1) if line.strip()]
    for number, line in numbered:
        name, label, score = _fields(path, number, line)
        mask = _read_mask(path.parent / name)
        if masks and len(mask) != length:
            raise BadInput(f"{name} has {len(mask)} lines, the masks before it {length}: they must be of one mesh")
        length = len(mask)
        key = len(masks) + 1
        masks[key], labels[key], scores[key] = np.flatnonzero(mask), label, score
    return Submission(masks, labels, scores, length)


def _is_list(path: Path) -> bool:
    with path.open(errors="replace") as file:
        first = file.readline().split()
    return len(first) == 3 and (path.parent / first[0]).suffix == ".txt"


def _fields(path: Path, number: int, line: str) -> tuple[str, int, float]:
    try:
        name, label, score = line.split()
        return name, int(label), float(score)
    except ValueError:
        raise BadInput(f"{path}, line {number}: expected `mask_file class confidence`, got '{line.strip()}'") from None


def _read_mask(path: Path) -> BoolArray:
    try:
        return np.array(path.read_bytes().split(), np.float64) != 0
    except OSError:
        raise BadInput(f"{path} is missing: a submission needs the mask files that its list names") from None
    except ValueError:
        raise BadInput(f"{path} must hold one number a line, not 0 for vertices of the mask") from None
