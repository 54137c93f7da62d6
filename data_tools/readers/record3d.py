"""Reader of Record3D exports: a .r3d archive, or a folder with rgb/ and depth/ images (its "EXR + JPG" export).

The metadata holds K (column by column, pixels of the colour image), w, h, fps, poses [qx qy qz qw tx ty tz] and
frameTimestamps. Poses are ARKit's: world_from_camera of a camera with y up and z backwards. Depth is in metres, of
lower resolution than colour and with the same rays. Confidence is 0, 1 or 2; depth of confidence 0 is left out.
Source: https://record3d.app, https://github.com/marek-simonik/record3d
"""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from scipy.spatial.transform import Rotation

from data_tools.readers.record3d_images import ArchiveImages, FolderImages, opened
from data_tools.recordings.camera import Camera, Declared
from data_tools.recordings.recorded_sequence import RecordedSequence, recorded_sequence
from data_tools.recordings.trajectories import PoseWithNotes, checked_pose
from razer.errors import BadInput, UnusableFrame
from razer.files import MALFORMED, beginning, parse_json, read_json

_FRAMES_PER_SECOND = 60.0  # where neither stamps nor fps are there; the app's default
_BEGINNING_BYTES = 2**24
_LONGEST_NUMBER = 9  # digits
_CV_FROM_GL = np.diag([1.0, -1.0, -1.0, 1.0])


@dataclass(frozen=True, slots=True)
class ArkitPoses:
    """Rows qx qy qz qw tx ty tz in ARKit's camera axes, one for each frame."""

    rows: tuple[tuple[float, ...], ...]

    def __call__(self, index: int) -> PoseWithNotes:
        """The pose of a frame in OpenCV's camera axes; raises UnusableFrame."""
        if index >= len(self.rows):
            raise UnusableFrame(f"metadata has no pose {index}")
        row = np.array(self.rows[index], dtype=np.float64)
        if row.shape != (7,) or not abs(np.linalg.norm(row[:4]) - 1) <= 0.01:  # also refuses nan
            raise UnusableFrame(f"metadata, pose {index}: a unit quaternion and a position are needed")
        pose = np.eye(4)
        pose[:3, :3], pose[:3, 3] = Rotation.from_quat(row[:4]).as_matrix(), row[4:]
        return checked_pose(pose @ _CV_FROM_GL, f"metadata, pose {index}")


def is_record3d(path: Path) -> bool:
    """Whether this is a .r3d archive, such an archive unpacked, or an EXR + JPG export."""
    if path.is_file():
        return path.suffix.lower() == ".r3d"
    if (path / "metadata").is_file():
        return (path / "rgbd").is_dir()
    metadata = path / "metadata.json"
    if not (metadata.is_file() and (path / "rgb").is_dir() and (path / "depth").is_dir()):
        return False
    content = beginning(metadata, _BEGINNING_BYTES)
    return b'"poses"' in content and (b'"K"' in content or b'"perFrameIntrinsicCoeffs"' in content)


def read_record3d(folder: Path, declared: Declared, use_poses: bool) -> RecordedSequence:
    """An export in one of these forms; raises BadInput, also where a package that it takes is missing."""
    metadata = _metadata(folder)
    try:
        recorded = Declared(_camera(metadata))
        poses = tuple(tuple(float(x) for x in row) for row in metadata.get("poses", ()))
        depth_size = (int(metadata.get("dw", 0)), int(metadata.get("dh", 0)))
        stamps = tuple(float(stamp) for stamp in metadata.get("frameTimestamps", ()))
        rate = float(metadata.get("fps", _FRAMES_PER_SECOND))
    except MALFORMED as error:
        raise BadInput(f"{folder}: its metadata is not that of a Record3D export (problem: {error!r})") from None
    numbers = _numbers(folder)
    is_recorded = len(stamps) > max(numbers, default=0)
    if not is_recorded:
        stamps = tuple(i / rate for i in range(max(numbers, default=0) + 1))
    images = FolderImages if (folder / "metadata.json").is_file() else ArchiveImages
    source = images(folder, numbers, tuple(stamps[n] for n in numbers), depth_size)
    source.require_packages()
    pose_of = ArkitPoses(tuple(poses[n] if n < len(poses) else () for n in numbers)) if use_poses and poses else None
    return recorded_sequence(folder, source, declared.or_else(recorded), pose_of, recorded_stamps=is_recorded)


def _metadata(path: Path) -> dict[str, Any]:
    # Poses that are not finite cost their frames alone.
    if not path.is_file():
        content = read_json(_metadata_file(path), only_finite=False)
    else:
        try:
            text = opened(path).read("metadata")
        except BadInput as error:
            raise BadInput(f"{error}: it is no whole .r3d archive, copy it from the phone again") from None
        content = parse_json(text, f"{path}, its metadata", only_finite=False)
    if not isinstance(content, dict):
        raise BadInput(f"{path}: its metadata is not that of a Record3D export")
    return content


def _metadata_file(folder: Path) -> Path:
    path = folder / "metadata.json"
    return path if path.is_file() else folder / "metadata"


def _camera(metadata: dict[str, Any]) -> Camera:
    """The camera of the colour images; where each frame has its own, as the lens focuses, the one in the middle."""
    size = (int(metadata["w"]), int(metadata["h"]))
    if rows := metadata.get("perFrameIntrinsicCoeffs"):
        fx, fy, cx, cy = np.median(np.array(rows, dtype=np.float64)[:, :4], axis=0).tolist()
    else:
        fx, _, _, _, fy, _, cx, cy, _ = (float(x) for x in metadata["K"])
    return Camera(fx, fy, cx, cy, size=size)


def _numbers(path: Path) -> tuple[int, ...]:
    if path.is_file():
        names = [name.removeprefix("rgbd/") for name in opened(path).names if name.startswith("rgbd/")]
    else:
        names = [file.name for part in ("rgbd", "rgb", "depth") for file in (path / part).glob("*")]
    stems = {name.rpartition(".")[0] for name in names if not name.endswith(".conf")}
    return tuple(sorted(int(stem) for stem in stems if stem.isdecimal() and len(stem) <= _LONGEST_NUMBER))
