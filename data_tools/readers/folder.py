"""Reader of the project's own layout, and of any folder with a color/ and a depth/ folder of images in it."""

from __future__ import annotations

import os
from pathlib import Path

from data_tools.readers.pairing import Pair, pair_images
from data_tools.recordings.camera import Declared, read_camera_file
from data_tools.recordings.image_files import ImagePaths, file_sequence
from data_tools.recordings.images import IMAGE_SUFFIXES
from data_tools.recordings.recorded_sequence import RecordedSequence
from data_tools.recordings.trajectories import InterpolatedPoses, NearestPoses, PoseFiles, PoseSource, read_trajectory
from razer.errors import BadInput
from razer.files import MALFORMED, read_json, read_numbers

MILLIMETRES = 1000.0
_COLOR_FOLDERS = ("color", "rgb")
_POSE_FOLDERS = ("pose", "poses")
_TRUE_IMAGES = ("ids", "parts")


def is_folder(folder: Path) -> bool:
    """Whether there are a colour and a depth folder."""
    return (folder / "depth").is_dir() and any((folder / name).is_dir() for name in _COLOR_FOLDERS)


def read_folder(folder: Path, declared: Declared, use_poses: bool) -> RecordedSequence:
    """A folder in this layout: intrinsics.json, color/, depth/, and optionally trajectory.txt (or pose/ with
    a 4x4 matrix a frame), stamps.txt, ids/ with truth/objects.json, parts/; raises BadInput."""
    color_folder = next(path for name in _COLOR_FOLDERS if (path := folder / name).is_dir())
    pairs, clocked = pair_images(folder, _images(color_folder), _images(folder / "depth"))
    stamps = _stamps(folder, pairs)
    paths = tuple(
        ImagePaths(
            pair.color or color_folder / f"{pair.key}.*",
            pair.depth or folder / "depth" / f"{pair.key}.png",
            stamp,
            *(folder / images / f"{pair.key}.png" if (folder / images).is_dir() else None for images in _TRUE_IMAGES),
        )
        for pair, stamp in zip(pairs, stamps, strict=True)
    )
    camera_file = folder / "intrinsics.json"
    recorded = read_camera_file(camera_file) if camera_file.exists() else Declared()
    declared = declared.or_else(recorded).or_else(Declared(depth_scale=MILLIMETRES))
    pose_of = _poses(folder, [pair.key for pair in pairs], stamps, clocked) if use_poses else None
    is_recorded = clocked or (folder / "stamps.txt").exists()
    return file_sequence(folder, paths, declared, pose_of, _class_names(folder), recorded_stamps=is_recorded)


def _images(folder: Path) -> dict[str, Path]:
    """Image files by the name before the suffix."""
    return {path.stem: path for path in sorted(folder.iterdir()) if path.suffix.lower() in IMAGE_SUFFIXES}


def _stamps(folder: Path, pairs: list[Pair]) -> list[float]:
    """Seconds, one for each frame: from stamps.txt, else what the names say, else frame number / 30."""
    path = folder / "stamps.txt"
    if not path.exists():
        return [pair.stamp for pair in pairs]
    stamps = read_numbers(path, "one number of seconds a line").tolist()
    if len(stamps) != len(pairs):
        raise BadInput(f"{path} has {len(stamps)} stamps for {len(pairs)} frames: it needs one each")
    return stamps


def _poses(folder: Path, keys: list[str], stamps: list[float], clocked: bool) -> PoseSource | None:
    if os.path.lexists(folder / "trajectory.txt"):
        trajectory = read_trajectory(folder / "trajectory.txt")
        return (InterpolatedPoses if clocked else NearestPoses)(trajectory, tuple(stamps))
    for name in _POSE_FOLDERS:
        if (folder / name).is_dir():
            return PoseFiles(tuple(folder / name / f"{key}.txt" for key in keys))
    return None


def _class_names(folder: Path) -> dict[int, str]:
    path = folder / "truth" / "objects.json"
    if not path.is_file():
        return {}
    try:
        return {int(item["id"]): str(item["class"]) for item in read_json(path)}
    except MALFORMED as error:
        raise BadInput(f'{path} must be a list of {{"id": 1, "class": "chair"}} (problem: {error})') from error
