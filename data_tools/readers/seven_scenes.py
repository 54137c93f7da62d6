"""Reader of 7-Scenes and of tools that write like it: frame-000000.color.jpg, .depth.png, .pose.txt."""

from __future__ import annotations

import re
from pathlib import Path

from data_tools.recordings.camera import Declared, read_camera_matrix
from data_tools.recordings.image_files import ImagePaths, file_sequence
from data_tools.recordings.recorded_sequence import RecordedSequence
from data_tools.recordings.trajectories import PoseFiles

MILLIMETRES = 1000.0
FRAMES_PER_SECOND = 30.0
_NAME = re.compile(r"frame-(\d+)\.(color|depth|pose)\.\w+")


def is_seven_scenes(folder: Path) -> bool:
    """Whether the folder holds frames in this layout."""
    return any(_NAME.fullmatch(path.name) for path in folder.glob("frame-*"))


def read_seven_scenes(folder: Path, declared: Declared, use_poses: bool) -> RecordedSequence:
    """A folder in this layout: depth in millimetres, poses world_from_camera, the camera matrix in
    camera-intrinsics.txt where it is there; raises BadInput."""
    files: dict[str, dict[str, Path]] = {}
    for path in folder.iterdir():
        if match := _NAME.fullmatch(path.name):
            files.setdefault(match[1], {})[match[2]] = path
    numbers = sorted((n for n, kinds in files.items() if {"color", "depth"} & kinds.keys()), key=int)
    paths = tuple(_image_paths(folder, number, files[number]) for number in numbers)
    has_poses = use_poses and any("pose" in files[number] for number in numbers)
    poses = PoseFiles(tuple(files[n].get("pose", folder / f"frame-{n}.pose.txt") for n in numbers))
    return file_sequence(folder, paths, declared.or_else(_defaults(folder)), poses if has_poses else None)


def _image_paths(folder: Path, number: str, kinds: dict[str, Path]) -> ImagePaths:
    color = kinds.get("color", folder / f"frame-{number}.color.png")
    depth = kinds.get("depth", folder / f"frame-{number}.depth.png")
    return ImagePaths(color, depth, int(number) / FRAMES_PER_SECOND)


def _defaults(folder: Path) -> Declared:
    path = folder / "camera-intrinsics.txt"
    return Declared(read_camera_matrix(path) if path.exists() else None, depth_scale=MILLIMETRES)
