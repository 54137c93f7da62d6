"""Predicted instances as submitted to the ScanNet benchmark: mask files with a class and a confidence each."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

from data_tools.predictions.mask_file import read_mask
from data_tools.predictions.packed_masks import PackedMasks
from razer.errors import BadInput
from razer.files import beginning, read_lines
from razer.vocabulary import MAX_ID

_BEGINNING_BYTES = 4096


@dataclass(frozen=True, slots=True)
class Submission:
    """masks: (V,) by prediction, numbered from 1 in the order of the file; they may overlap. labels and scores: the
    class number and confidence of each."""

    masks: PackedMasks
    labels: Mapping[int, int]
    scores: Mapping[int, float]

    @property
    def n_vertices(self) -> int:
        """Lines of the mask files."""
        return self.masks.n_vertices


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
    """Read a list of `mask_file class confidence`, one mask at a time; raises BadInput naming file and line."""
    masks = PackedMasks()
    labels: dict[int, int] = {}
    scores: dict[int, float] = {}
    numbered = [(n, line) for n, line in enumerate(read_lines(path), start=1) if line.strip()]
    for number, line in numbered:
        name, label, score = _fields(path, number, line)
        if Path(name).is_absolute() or ".." in Path(name).parts:
            raise BadInput(f"{path}, line {number}: {name} leads out of the folder of the submission")
        mask = read_mask(path.parent / name)
        if masks and len(mask) != masks.n_vertices:
            of_others = masks.n_vertices
            raise BadInput(f"{name} has {len(mask)} lines, the masks before it {of_others}: they must be of one mesh")
        key = masks.add(mask)
        labels[key], scores[key] = label, score
    return Submission(masks, labels, scores)


def _is_list(path: Path) -> bool:
    first, *_ = [*beginning(path, _BEGINNING_BYTES).decode("utf-8", "replace").splitlines(), ""]
    # A scene in which nothing was found has an empty list.
    fields = first.split()
    return not first or (len(fields) == 3 and (path.parent / fields[0]).suffix == ".txt")


def _fields(path: Path, number: int, line: str) -> tuple[str, int, float]:
    try:
        name, label, score = line.split()
        if not float(label).is_integer() or abs(float(label)) > MAX_ID or not math.isfinite(float(score)):
            raise ValueError
        return name, int(float(label)), float(score)
    except ValueError:
        raise BadInput(f"{path}, line {number}: expected `mask_file class confidence`, got '{line.strip()}'") from None
