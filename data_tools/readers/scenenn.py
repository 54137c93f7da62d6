"""Reader of SceneNN with its videos extracted: image/image00001.png, depth/depth00001.png, trajectory.log.

The dataset's playback tool numbers images from 1 and writes timestamp.txt (image, stamp of colour, stamp of depth
in microseconds); the log counts from 0, so that pose n belongs to image n + 1, as the tools of others have it.
Source: https://github.com/hkust-vgd/scenenn
"""

from __future__ import annotations

import re
from pathlib import Path

from data_tools.recordings.camera import Camera, Declared, read_camera_matrix
from data_tools.recordings.image_files import ImagePaths, file_sequence
from data_tools.recordings.pose_log import LogPoses, read_pose_log
from data_tools.recordings.recorded_sequence import RecordedSequence
from razer.files import read_text

MILLIMETRES = 1000.0
FRAMES_PER_SECOND = 30.0
_LONGEST_NUMBER = 19  # digits of what counts microseconds
CAMERA = Camera(544.47329, 544.47329, 320.0, 240.0, size=(640, 480))
_NAMES = {kind: re.compile(rf"{kind}(\d+)\.(?:png|jpe?g)") for kind in ("image", "depth")}


def is_scenenn(folder: Path) -> bool:
    """Whether there are images and depth under the names of this layout."""
    return all(_numbered(folder, kind) for kind in _NAMES)


def read_scenenn(folder: Path, declared: Declared, use_poses: bool) -> RecordedSequence:
    """A folder in this layout: depth in millimetres, poses world_from_camera; the camera is the dataset's unless
    intrinsic.txt holds another 3x3 matrix; raises BadInput."""
    images, depths = _numbered(folder, "image"), _numbered(folder, "depth")
    numbers = sorted(images.keys() | depths.keys())
    stamps = _stamps(folder / "timestamp.txt")
    paths = tuple(
        ImagePaths(
            images.get(n, folder / "image" / f"image{n:05d}.png"),
            depths.get(n, folder / "depth" / f"depth{n:05d}.png"),
            stamps.get(n, (n - 1) / FRAMES_PER_SECOND),
        )
        for n in numbers
    )
    log = _log(folder) if use_poses else None
    poses = _poses(log, numbers) if log else None
    path = folder / "intrinsic.txt"
    defaults = Declared(read_camera_matrix(path) if path.is_file() else CAMERA, depth_scale=MILLIMETRES)
    return file_sequence(folder, paths, declared.or_else(defaults), poses, recorded_stamps=bool(stamps))


def _numbered(folder: Path, kind: str) -> dict[int, Path]:
    matches = ((path, _NAMES[kind].fullmatch(path.name)) for path in (folder / kind).glob("*"))
    return {int(match[1]): path for path, match in matches if match}


def _log(folder: Path) -> Path | None:
    """trajectory.log, or 005_trajectory.log as the dataset's separate download names it."""
    path = folder / "trajectory.log"
    return path if path.is_file() else next(iter(sorted(folder.glob("*_trajectory.log"))), None)


def _poses(log: Path, numbers: list[int]) -> LogPoses:
    poses = read_pose_log(log)
    # A log that counts as the images do ends with the number of the last one; the dataset's ends one before.
    first = 1 if 0 not in poses and numbers and max(poses) == numbers[-1] else 0
    return LogPoses(log.name, poses, tuple(n - 1 + first for n in numbers))


def _stamps(path: Path) -> dict[int, float]:
    """Seconds of depth by image number; lines of another form are passed over, as some tools add columns."""
    if not path.is_file():
        return {}
    lines = (line.split() for line in read_text(path, replace_errors=True).splitlines())
    rows = (
        line
        for line in lines
        if len(line) == 3 and all(word.isdecimal() and len(word) <= _LONGEST_NUMBER for word in line)
    )
    return {int(number): int(depth_us) / 1e6 for number, _, depth_us in rows}
