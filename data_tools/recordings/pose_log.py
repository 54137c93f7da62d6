"""Trajectories in the .log format of Redwood, used by Open3D and SceneNN too.

Each pose is five lines: three whole numbers, the first of which counts the frames from 0, and the four rows of
world_from_camera in metres. Source: http://redwood-data.org/indoor/fileformat.html
"""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from data_tools.recordings.trajectories import PoseWithNotes, checked_pose
from razer.arrays import Float64Array
from razer.errors import BadInput, UnusableFrame
from razer.files import beginning, read_text

_BEGINNING_BYTES = 4096
_HEADER = re.compile(r"\s*(-?\d{1,18})\s+-?\d+\s+-?\d+\s*")


@dataclass(frozen=True, slots=True)
class LogPoses:
    """The poses of a log by number, and the number that belongs to each frame of a sequence."""

    source: str
    poses: Mapping[int, Float64Array]
    numbers: tuple[int, ...]

    def __call__(self, index: int) -> PoseWithNotes:
        """The pose of a frame; raises UnusableFrame where it has none or no usable one."""
        number = self.numbers[index]
        if number not in self.poses:
            raise UnusableFrame(f"{self.source} has no pose {number}")
        return checked_pose(self.poses[number], f"{self.source}, pose {number}")


def is_pose_log(path: Path) -> bool:
    """Whether a text file begins like a log: three whole numbers, then a row of four."""
    first, second = [*beginning(path, _BEGINNING_BYTES).decode("utf-8", "replace").splitlines(), "", ""][:2]
    return bool(_HEADER.fullmatch(first)) and len(second.split()) == 4


def read_pose_log(path: Path) -> dict[int, Float64Array]:
    """The matrices (4, 4) of a log by the first number of each; raises BadInput naming the file and the line.

    What is no number becomes nan, and a pose that is cut off at the end is left out: those frames have no usable
    pose, the others keep theirs. Where the numbers repeat, poses are counted in their order from 0."""
    lines = [(i, line) for i, line in enumerate(read_text(path, replace_errors=True).splitlines(), 1) if line.strip()]
    numbers, poses = [], []
    for first in range(0, len(lines) - 4, 5):
        line_number, header = lines[first]
        header_match = _HEADER.fullmatch(header)
        if not header_match:
            raise BadInput(
                f"{path}, line {line_number}: expected three whole numbers before each 4x4 pose, got '{header[:40]}'"
            )
        numbers.append(int(header_match[1]))
        poses.append(np.array([_row(line) for _, line in lines[first + 1 : first + 5]]))
    if not poses:
        raise BadInput(f"{path} holds no pose: it needs three whole numbers and then a 4x4 matrix for each frame")
    if len(set(numbers)) < len(numbers):
        numbers = list(range(len(poses)))
    return dict(zip(numbers, poses, strict=True))


def _row(line: str) -> list[float]:
    numbers = [_number(word) for word in line.split()]
    return numbers if len(numbers) == 4 else [np.nan] * 4


def _number(word: str) -> float:
    try:
        return float(word)
    except ValueError:  # such as the -1.#IND of some compilers
        return np.nan
