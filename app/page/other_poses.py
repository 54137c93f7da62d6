"""The same place mapped with other poses, where a comparison of both runs lies beside a run."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from app.comparison.folder import NUMBERS
from razer.arrays import Float64Array
from razer.files import MALFORMED, read_json

FIRST, SECOND, COMPARED = "given", "slam", "compare"  # the folders of `razer run --poses both`


@dataclass(frozen=True)
class OtherPoses:
    """The run B that run A was compared with, and what brings B's frame to A's (4, 4)."""

    folder: Path
    a_from_b: Float64Array


def chosen_run(folder: Path) -> Path:
    """The run with given poses where a folder holds a pair with its comparison, else the folder itself."""
    return folder / FIRST if (folder / COMPARED / NUMBERS).is_file() and (folder / FIRST).is_dir() else folder


def other_poses(run: Path) -> OtherPoses | None:
    """The run with estimated poses beside one with given poses; None where there is none, or nothing aligns both."""
    pair = Path(run).absolute()
    numbers = pair.parent / COMPARED / NUMBERS
    if pair.name != FIRST or not numbers.is_file() or not (pair.parent / SECOND).is_dir():
        return None
    try:
        matrix = np.array(read_json(numbers, only_finite=False)["alignment"]["a_from_b"], dtype=np.float64)
    except MALFORMED:
        return None
    return OtherPoses(pair.parent / SECOND, matrix) if matrix.shape == (4, 4) and np.isfinite(matrix).all() else None
