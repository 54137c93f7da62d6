"""KITTI's poses: a line a frame, the twelve numbers of [R | t] row by row, camera to world.

Source: https://www.cvlibs.net/datasets/kitti/eval_odometry.php
"""

from __future__ import annotations

from pathlib import Path

import numpy as np

from data_tools.trajectory_files.frame_poses import FramePoses
from razer.errors import BadInput
from razer.files import read_lines

NUMBERS = 12
KIND = "KITTI, a line a frame"


def poses_by_line(path: Path, n_frames: int) -> tuple[FramePoses, str]:
    """The poses of a KITTI file, the n-th line's for the n-th frame, and how they were matched; raises BadInput naming
    the line, and where there are not as many lines as frames."""
    numbered = enumerate(read_lines(path), 1)
    lines = [(number, line) for number, line in numbered if line.strip() and not line.lstrip().startswith("#")]
    if len(lines) != n_frames:
        raise BadInput(f"{path} has {len(lines)} poses for {n_frames} frames: it needs a line for each of them")
    poses = {}
    for frame, (number, line) in enumerate(lines):
        poses[frame] = np.eye(4)
        poses[frame][:3] = _row(line, f"{path}, line {number}")
    return FramePoses(path.name, poses), KIND


def _row(line: str, place: str) -> np.ndarray:
    try:
        numbers = np.array(line.split(), dtype=np.float64)
    except ValueError:
        raise BadInput(f"{place}: expected {NUMBERS} numbers, got '{line[:40]}'") from None
    if numbers.size != NUMBERS:
        raise BadInput(f"{place}: expected {NUMBERS} numbers, got {numbers.size}")
    return numbers.reshape(3, 4)
