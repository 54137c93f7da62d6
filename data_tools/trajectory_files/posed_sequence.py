"""A recording under the poses of a file: TUM, KITTI, COLMAP's images.txt, or transforms.json, told by its content."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np

from data_tools.recordings.local_origin import local_origin
from data_tools.recordings.plausibility import implausible_frames, positions_of
from data_tools.recordings.recorded_sequence import RecordedSequence
from data_tools.recordings.sequence import RgbdSequence
from data_tools.recordings.trajectories import PoseSource
from data_tools.trajectory_files import colmap_images, transforms_json
from data_tools.trajectory_files.matrix_lines import NUMBERS, poses_by_line
from data_tools.trajectory_files.metric_scale import from_depth_camera, in_metres
from data_tools.trajectory_files.named_images import NamedPose, poses_by_name
from data_tools.trajectory_files.timed_lines import poses_by_time
from razer.errors import BadInput, UnusableFrame
from razer.files import beginning, opened

_BEGINNING_BYTES = 65536  # comments, and a first line
_TUM_NUMBERS = 8
FORMS = (
    "give lines `stamp tx ty tz qx qy qz qw` (TUM), 12 numbers a line (KITTI), COLMAP's images.txt, or transforms.json"
)


def posed_by(sequence: RgbdSequence, path: Path) -> RecordedSequence:
    """The recording with the poses of a file in place of its own; `poses_note` says what they are and how many frames
    have one.

    Args:
        sequence: the recording.
        path: the file.

    Raises:
        BadInput: naming the file and the place in it where it cannot be read, is of no known kind, or has a pose for
            none of the frames.
    """
    if not isinstance(sequence, RecordedSequence):
        raise BadInput(f"{path}: {sequence.name} is read by a reader of your own, which alone can pose its frames")
    stamps = np.array([sequence.images.stamp(index) for index in range(len(sequence))], dtype=np.float64)
    pose_of, matched = _poses(sequence, path, stamps)
    positions = positions_of(pose_of, len(sequence))
    n_posed = int(np.isfinite(positions).all(axis=1).sum())
    if not n_posed:
        raise BadInput(f"{path} has a pose for none of the {len(sequence)} frames: {_reason(pose_of)}")
    return replace(
        sequence,
        pose_of=pose_of,
        implausible=implausible_frames(path, stamps, positions, recorded_stamps=sequence.recorded_stamps),
        origin=local_origin(positions),
        poses_note=f"poses from {path.name} ({matched}): {n_posed} of {len(sequence)} frames have one",
    )


def _poses(sequence: RecordedSequence, path: Path, stamps: np.ndarray) -> tuple[PoseSource, str]:
    """The poses of a file, and what kind it is and how they were matched."""
    with opened(path):  # whatever cannot be opened says so
        text = beginning(path, _BEGINNING_BYTES).decode("utf-8-sig", "replace")
    if text.lstrip().startswith("{"):
        return _by_name(sequence, path, transforms_json.read_transforms, transforms_json.KIND)
    first = next((line for line in text.splitlines() if line.strip() and not line.lstrip().startswith("#")), "")
    n_numbers = _n_numbers(first)
    if n_numbers == NUMBERS:
        return poses_by_line(path, len(sequence))
    if n_numbers == _TUM_NUMBERS:
        return poses_by_time(path, stamps)
    if colmap_images.is_image_line(first):
        return _by_name(sequence, path, colmap_images.read_colmap_images, colmap_images.KIND)
    raise BadInput(f"{path} is no file of poses that is known (it begins with '{first[:40]}'): {FORMS}")


def _by_name(
    sequence: RecordedSequence, path: Path, read: Callable[[Path], list[NamedPose]], kind: str
) -> tuple[PoseSource, str]:
    """Poses of images: of the colour camera, and in any unit."""
    colors = [sequence.images.color_file(index) for index in range(len(sequence))]
    found = poses_by_name(path, read(path), colors)
    metric, scale = in_metres(sequence, found)
    return from_depth_camera(metric, sequence.rgbd_alignment.color_from_depth), f"{kind}, {scale}"


def _n_numbers(line: str) -> int:
    """How many numbers a line consists of, 0 where something else is in it."""
    words = line.split()
    try:
        return len([float(word) for word in words])
    except ValueError:
        return 0


def _reason(pose_of: PoseSource) -> str:
    try:
        pose_of(0)
    except UnusableFrame as error:
        return str(error)
    return "none is usable"
