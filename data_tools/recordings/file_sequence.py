"""A recording kept as one colour and one depth file a frame: what all folder layouts come down to."""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from data_tools.recordings.camera import HOW_TO_DECLARE, Declared
from data_tools.recordings.images import read_depth, read_ids, read_rgb, short_name, size_of
from data_tools.recordings.rgbd_alignment import RgbdAlignment, Size, make_rgbd_alignment
from data_tools.recordings.trajectories import PoseSource
from razer.errors import BadInput, UnusableFrame
from razer.frame import Frame, Intrinsics

_PROBES = 5  # frames decoded to learn the image sizes: a few damaged ones must not decide


@dataclass(frozen=True, slots=True)
class Shot:
    """The files of one frame; ids is an image of instance ids on the depth grid; stamp in seconds."""

    color: Path
    depth: Path
    stamp: float
    ids: Path | None = None


@dataclass(frozen=True)
class FileSequence:
    """A Sequence over shots; pose_of is None for a recording without poses."""

    name: str
    shots: tuple[Shot, ...]
    registration: RgbdAlignment
    depth_scale: float
    pose_of: PoseSource | None = None
    class_names: Mapping[int, str] = field(default_factory=dict)

    @property
    def intrinsics(self) -> Intrinsics:
        """The pinhole camera of every frame."""
        return self.registration.intrinsics

    @property
    def has_poses(self) -> bool:
        """Whether frames come with world_from_camera."""
        return self.pose_of is not None

    def __len__(self) -> int:
        return len(self.shots)

    def __getitem__(self, index: int) -> Frame:
        """The frame at `index`; raises UnusableFrame with the reason, or IndexError past the end."""
        if not 0 <= index < len(self.shots):
            raise IndexError(index)
        shot = self.shots[index]
        # The pose comes first: a frame that has none need not be decoded.
        pose, notes = (None, ()) if self.pose_of is None else self.pose_of(index)
        depth = read_depth(shot.depth, self.depth_scale)
        _check_size(shot.depth, size_of(depth), self.registration.depth_size)
        depth = self.registration.on_depth_grid(depth)
        rgb = read_rgb(shot.color)
        _check_size(shot.color, size_of(rgb), self.registration.color_size)
        rgb = self.registration.color(rgb, depth)
        ids = self._ids(shot)
        names = self.class_names if ids is not None else {}
        return Frame(index, shot.stamp, rgb, depth, self.intrinsics, pose, ids, names, notes)

    def _ids(self, shot: Shot) -> np.ndarray | None:
        if shot.ids is None:
            return None
        ids = read_ids(shot.ids)
        _check_size(shot.ids, size_of(ids), self.registration.depth_size)
        return self.registration.on_depth_grid(ids.astype(np.float32)).astype(np.int32)


def file_sequence(
    folder: Path,
    shots: tuple[Shot, ...],
    declared: Declared,
    pose_of: PoseSource | None,
    class_names: Mapping[int, str] | None = None,
) -> FileSequence:
    """The sequence of `shots`, with everything checked that one look at the folder can check: raises
    BadInput for unknown intrinsics, unknown relation of colour and depth, or no readable image."""
    if not shots:
        raise BadInput(f"{folder} holds no frames")
    if declared.depth_camera is None or declared.depth_scale is None:
        raise BadInput(f"{folder} does not say what camera took it: give {HOW_TO_DECLARE}")
    color_size, depth_size = _image_sizes(folder, shots, declared.depth_scale)
    try:
        registration = make_rgbd_alignment(declared, color_size, depth_size)
    except BadInput as error:
        raise BadInput(f"{folder}: {error}") from None
    return FileSequence(folder.name, shots, registration, declared.depth_scale, pose_of, dict(class_names or {}))


def _image_sizes(folder: Path, shots: tuple[Shot, ...], depth_scale: float) -> tuple[Size, Size]:
    """The commonest sizes of colour and depth over a few frames spread over the recording."""
    found: Counter[tuple[Size, Size]] = Counter()
    last_error = UnusableFrame("no frames")
    spread = np.linspace(0, len(shots) - 1, _PROBES).round().astype(int)
    for i in dict.fromkeys([*spread.tolist(), *range(len(shots))]):
        if found.total() >= min(_PROBES, len(shots)):
            break
        try:
            color, depth = read_rgb(shots[i].color), read_depth(shots[i].depth, depth_scale)
        except UnusableFrame as error:
            last_error = error
        else:
            found[size_of(color), size_of(depth)] += 1
    if not found:
        raise BadInput(f"{folder} holds no usable frame; the last problem was: {last_error}")
    return found.most_common(1)[0][0]


def _check_size(path: Path, size: Size, expected: Size) -> None:
    if size != expected:
        raise UnusableFrame(f"{short_name(path)} is {size[0]}x{size[1]} where others are {expected[0]}x{expected[1]}")
