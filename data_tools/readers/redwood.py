"""Reader of Redwood and of Open3D's reconstruction system: color/ and depth/ images with a .log trajectory.

The camera is a JSON file with Open3D's column-major intrinsic_matrix, or an intrinsics.json of the project's own
layout, or else the PrimeSense camera that Open3D takes as its default.
Sources: http://redwood-data.org/indoor/fileformat.html and
https://www.open3d.org/docs/release/tutorial/reconstruction_system/
"""

from __future__ import annotations

import re
from pathlib import Path

from data_tools.recordings.camera import Camera, Declared, read_camera_file
from data_tools.recordings.image_files import ImagePaths, file_sequence
from data_tools.recordings.images import IMAGE_SUFFIXES
from data_tools.recordings.pose_log import LogPoses, is_pose_log, read_pose_log
from data_tools.recordings.recorded_sequence import RecordedSequence
from razer.errors import BadInput
from razer.files import MALFORMED, read_json

MILLIMETRES = 1000.0
FRAMES_PER_SECOND = 30.0
PRIMESENSE = Camera(525.0, 525.0, 319.5, 239.5, size=(640, 480))
_COLOR_FOLDERS = ("color", "image", "rgb", "colors")
_LOG_PLACES = ("trajectory.log", "scene/trajectory.log", "*.log", "*traj*.txt")


def is_redwood(folder: Path) -> bool:
    """Whether there are a colour and a depth folder and a trajectory in .log form."""
    return (folder / "depth").is_dir() and bool(_color_folders(folder)) and _log(folder) is not None


def read_redwood(folder: Path, declared: Declared, use_poses: bool) -> RecordedSequence:
    """A folder in this layout: depth in millimetres, poses world_from_camera; raises BadInput."""
    color_folder = _color_folders(folder)[0]
    color, depth = _numbered(color_folder), _numbered(folder / "depth")
    numbers = sorted(color.keys() | depth.keys())
    if not numbers:
        raise BadInput(f"{folder} holds no frames: its images need a number in their names")
    paths = tuple(
        ImagePaths(
            color.get(n, color_folder / f"{n}.*"),
            depth.get(n, folder / "depth" / f"{n}.png"),
            (n - numbers[0]) / FRAMES_PER_SECOND,
        )
        for n in numbers
    )
    log = _log(folder) if use_poses else None
    poses = None
    if log:
        entries = read_pose_log(log)
        poses = LogPoses(log.name, entries, _pose_numbers(numbers, sorted(entries)))
    return file_sequence(folder, paths, declared.or_else(_camera(folder)), poses)


def _color_folders(folder: Path) -> list[Path]:
    return [path for name in _COLOR_FOLDERS if (path := folder / name).is_dir()]


def _log(folder: Path) -> Path | None:
    inside = (path for place in _LOG_PLACES for path in sorted(folder.glob(place)))
    # The scenes of Zhou and Koltun (2013) come as lounge_trajectory.log beside lounge_png/.
    beside = folder.parent / f"{folder.name.removesuffix('_png')}_trajectory.log"
    return next((path for path in [*inside, beside] if is_pose_log(path)), None)


def _numbered(folder: Path) -> dict[int, Path]:
    """Images by the first number in their names: 0000012-000000400400.png is the image 12 of a Redwood scan."""
    images = (path for path in sorted(folder.iterdir()) if path.suffix.lower() in IMAGE_SUFFIXES)
    return {int(digits[0]): path for path in images if (digits := re.search(r"\d+", path.stem))}


def _pose_numbers(images: list[int], poses: list[int]) -> tuple[int, ...]:
    """Which pose belongs to which image: in order where there are as many, as the tools that write logs take the
    files in order; else by number, counted from where the images begin (0 or 1)."""
    if len(images) == len(poses):
        return tuple(poses)
    shift = min(images[0], 1) - min(poses[0], 1)
    return tuple(n - shift for n in images)


def _camera(folder: Path) -> Declared:
    """What a JSON file with an intrinsic_matrix beside the images says, else the default camera."""
    for path in sorted(folder.glob("*.json")):
        try:
            content = read_json(path)
            matrix = content.get("intrinsic_matrix")
        except (ValueError, AttributeError):
            continue
        if matrix is not None:
            return _open3d_camera(path, content, matrix)
        if path.name == "intrinsics.json":
            return read_camera_file(path).or_else(Declared(depth_scale=MILLIMETRES))
    return Declared(PRIMESENSE, depth_scale=MILLIMETRES)


def _open3d_camera(path: Path, content: dict, matrix: list) -> Declared:
    try:
        fx, _, _, _, fy, _, cx, cy, _ = (float(x) for x in matrix)
        size = (int(content["width"]), int(content["height"]))
        return Declared(Camera(fx, fy, cx, cy, size=size), depth_scale=content.get("depth_scale", MILLIMETRES))
    except MALFORMED as error:
        raise BadInput(
            f"{path} must hold width, height and the 9 numbers of intrinsic_matrix column by column (problem: {error})"
        ) from None
