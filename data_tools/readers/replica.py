"""Reader of Replica as NICE-SLAM rendered it: images in results/, traj.txt, cam_params.json.

Images are results/frame000000.jpg and results/depth000000.png. Line n of traj.txt holds the 16 numbers of
world_from_camera of frame n, row by row, with OpenCV's camera axes. One cam_params.json lies beside all scenes.
Source: https://github.com/cvg/nice-slam
"""

from __future__ import annotations

import re
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from data_tools.recordings.camera import Camera, Declared
from data_tools.recordings.image_files import ImagePaths, file_sequence
from data_tools.recordings.recorded_sequence import RecordedSequence
from data_tools.recordings.trajectories import PoseWithNotes, checked_pose
from razer.errors import BadInput, UnusableFrame
from razer.files import MALFORMED, read_json, read_lines

FRAMES_PER_SECOND = 30.0
DEPTH_SCALE = 6553.5
CAMERA = Camera(600.0, 600.0, 599.5, 339.5, size=(1200, 680))
_NAMES = {"frame": re.compile(r"frame(\d+)\.(?:jpe?g|png)"), "depth": re.compile(r"depth(\d+)\.png")}


@dataclass(frozen=True, slots=True)
class PoseLines:
    """The numbers on each line of a trajectory, and the line that belongs to each frame of a sequence."""

    source: str
    lines: tuple[tuple[float, ...], ...]
    numbers: tuple[int, ...]

    def __call__(self, index: int) -> PoseWithNotes:
        """The pose of a frame; raises UnusableFrame where it has none or no usable one."""
        number = self.numbers[index]
        where = f"{self.source}, line {number + 1}"
        if number >= len(self.lines):
            raise UnusableFrame(f"{where}: there are only {len(self.lines)} poses")
        if len(self.lines[number]) != 16:
            raise UnusableFrame(f"{where}: a pose has 16 numbers, not {len(self.lines[number])}")
        return checked_pose(np.array(self.lines[number]).reshape(4, 4), where)


def is_replica(folder: Path) -> bool:
    """Whether results/ holds images under the names of this layout."""
    return all(_numbered(folder, kind) for kind in _NAMES)


def read_replica(folder: Path, declared: Declared, use_poses: bool) -> RecordedSequence:
    """A folder in this layout; the camera is in cam_params.json here or one folder up, or else NICE-SLAM's; raises
    BadInput. Stamps are number / 30 s."""
    images = _images(folder)
    path = folder / "traj.txt"
    poses = PoseLines(path.name, _lines(path), tuple(images)) if use_poses and path.is_file() else None
    return file_sequence(folder, tuple(images.values()), declared.or_else(_camera(folder)), poses)


def _images(folder: Path) -> dict[int, ImagePaths]:
    """Number -> images of each frame that has at least one of the two; a missing one is named like the others."""
    colors, depths = _numbered(folder, "frame"), _numbered(folder, "depth")
    results = folder / "results"
    return {
        n: ImagePaths(
            colors.get(n, results / f"frame{n:06d}.jpg"),
            depths.get(n, results / f"depth{n:06d}.png"),
            n / FRAMES_PER_SECOND,
        )
        for n in sorted(colors.keys() | depths.keys())
    }


def _numbered(folder: Path, kind: str) -> dict[int, Path]:
    matches = ((path, _NAMES[kind].fullmatch(path.name)) for path in (folder / "results").glob(f"{kind}*"))
    return {int(match[1]): path for path, match in matches if match}


def _lines(path: Path) -> tuple[tuple[float, ...], ...]:
    """The numbers of each line; a word that is no number becomes nan, so that only its frame has no pose."""
    return tuple(tuple(_number(word) for word in line.split()) for line in read_lines(path))


def _number(word: str) -> float:
    try:
        return float(word)
    except ValueError:
        return np.nan


def _camera(folder: Path) -> Declared:
    path = next((p for place in (folder, folder.parent) if (p := place / "cam_params.json").is_file()), None)
    if path is None:
        return Declared(CAMERA, depth_scale=DEPTH_SCALE)
    known = read_json(path)
    try:
        content = known["camera"]
        fx, fy, cx, cy, scale = (float(content[name]) for name in ("fx", "fy", "cx", "cy", "scale"))
        return Declared(Camera(fx, fy, cx, cy, size=(int(content["w"]), int(content["h"]))), depth_scale=scale)
    except BadInput as error:
        raise BadInput(f"{path}: {error}") from None
    except MALFORMED as error:
        raise BadInput(
            f'{path} must be JSON with "camera" and in it w, h, fx, fy, cx, cy, scale (problem: {error!r})'
        ) from None
