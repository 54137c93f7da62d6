"""Reader of the TUM RGB-D benchmark: rgb.txt, depth.txt, groundtruth.txt with time stamps."""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np

from data_tools.recordings.camera import Camera, Declared, read_camera_file
from data_tools.recordings.image_files import ImagePaths, file_sequence
from data_tools.recordings.recorded_sequence import RecordedSequence
from data_tools.recordings.trajectories import InterpolatedPoses, read_trajectory
from razer.arrays import Float64Array
from razer.errors import BadInput
from razer.files import read_lines

DEPTH_SCALE = 5000.0
MAX_DIFFERENCE_S = 0.02  # between a colour and a depth image of one frame, as the benchmark's tools have it
# The published pinhole parameters of the three cameras. Their published distortion is not applied: on
# freiburg1 (60 frames of rpy, depth of one frame seen from another 1, 3, 6, 10 frames later) the median
# depth error is 9.2, 17.1, 34.4, 52.8 mm as recorded and 9.5, 18.2, 36.8, 54.6 mm undistorted, because
# depth was registered by a driver that knew no distortion. The benchmark's authors advise the same.
CAMERAS = {
    "1": Camera(517.3, 516.5, 318.6, 255.3),
    "2": Camera(520.9, 521.0, 325.1, 249.7),
    "3": Camera(535.4, 539.2, 320.1, 247.6),
}


def is_tum(folder: Path) -> bool:
    """Whether the folder has the two lists of this layout."""
    return (folder / "rgb.txt").is_file() and (folder / "depth.txt").is_file()


def read_tum(folder: Path, declared: Declared, use_poses: bool) -> RecordedSequence:
    """A folder in this layout: colour and depth matched by time, poses interpolated at the time of depth,
    depth in 1/5000 m; an intrinsics.json of the project's own layout may hold the camera; raises BadInput."""
    color_stamps, color_files = _read_list(folder / "rgb.txt")
    depth_stamps, depth_files = _read_list(folder / "depth.txt")
    pairs = associate(color_stamps, depth_stamps, MAX_DIFFERENCE_S)
    if not pairs:
        raise BadInput(f"{folder}: no colour image in rgb.txt is within {MAX_DIFFERENCE_S} s of one in depth.txt")
    stamps = tuple(float(depth_stamps[d]) for _, d in pairs)
    paths = tuple(
        ImagePaths(folder / color_files[c], folder / depth_files[d], stamp)
        for (c, d), stamp in zip(pairs, stamps, strict=True)
    )
    truth = folder / "groundtruth.txt"
    trajectory = read_trajectory(truth) if use_poses and truth.is_file() else None
    poses = InterpolatedPoses(trajectory, stamps) if trajectory else None
    beside = folder / "intrinsics.json"
    recorded = read_camera_file(beside) if beside.is_file() else Declared(_known_camera(folder))
    defaults = recorded.or_else(Declared(depth_scale=DEPTH_SCALE))
    return file_sequence(folder, paths, declared.or_else(defaults), poses, recorded_stamps=True)


def associate(a: Float64Array, b: Float64Array, max_difference: float) -> list[tuple[int, int]]:
    """Index pairs (i, j), ascending in i, of stamps a_i and b_j at most `max_difference` apart: the closest
    pair first, each stamp used once. Stamps that are no finite numbers have no partner."""
    order = np.argsort(b, kind="stable")
    first = np.searchsorted(b[order], a - max_difference, side="left")
    last = np.searchsorted(b[order], a + max_difference, side="right")
    finite = np.flatnonzero(np.isfinite(a)).tolist()
    candidates = [(abs(a[i] - b[j]), i, int(j)) for i in finite for j in order[first[i] : last[i]]]
    used_a: set[int] = set()
    used_b: set[int] = set()
    pairs = []
    for _, i, j in sorted(candidates):
        if i not in used_a and j not in used_b:
            used_a.add(i)
            used_b.add(j)
            pairs.append((i, j))
    return sorted(pairs, key=lambda pair: a[pair[0]])


def _read_list(path: Path) -> tuple[Float64Array, list[str]]:
    stamps, files = [], []
    for number, line in enumerate(read_lines(path), start=1):
        if not line.strip() or line.lstrip().startswith("#"):
            continue
        stamp, _, name = line.strip().partition(" ")
        try:
            stamps.append(float(stamp))
        except ValueError:
            raise BadInput(f"{path}, line {number}: expected `timestamp filename`, got '{line}'") from None
        files.append(name.strip())
    return np.array(stamps), files


def _known_camera(folder: Path) -> Camera | None:
    """The published camera where the folder's name or the comments of its lists say freiburg1, 2 or 3."""
    comments = [
        line for name in ("rgb.txt", "depth.txt") for line in read_lines(folder / name) if line.lstrip().startswith("#")
    ]
    number = re.search(r"(?:freiburg|\bfr)([123])", "\n".join([folder.name, *comments]).replace("_", " "))
    return CAMERAS[number[1]] if number else None
