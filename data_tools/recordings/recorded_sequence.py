"""RGB-D frames decoded on demand: images of one source, brought onto the depth grid and joined with their poses."""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Protocol

import numpy as np

from data_tools.recordings.camera import HOW_TO_DECLARE, Declared
from data_tools.recordings.color_grid_ids import ids_on_depth_grid
from data_tools.recordings.images import size_of
from data_tools.recordings.local_origin import HERE, Origin, local_origin, moved_origin
from data_tools.recordings.plausibility import implausible_frames, positions_of
from data_tools.recordings.rgbd_alignment import RgbdAlignment, Size, make_rgbd_alignment
from data_tools.recordings.sequence import FrameIteration, RgbdSequence
from data_tools.recordings.trajectories import PoseSource, PoseWithNotes
from razer.arrays import Float32Array, Int32Array, Uint8Array, Uint16Array
from razer.errors import BadInput, UnusableFrame
from razer.frame import Frame, Intrinsics

_PROBES = 5  # frames decoded to learn the image sizes: a few damaged ones must not decide


class ImageSource(Protocol):
    """Pairs of colour and depth as they were recorded, read in any order; can be pickled."""

    def __len__(self) -> int: ...

    def stamp(self, index: int) -> float:
        """When a pair was taken, in seconds."""

    def color(self, index: int) -> Uint8Array:
        """(H, W, 3) in RGB order; raises UnusableFrame."""

    def depth(self, index: int) -> Float32Array:
        """(h, w) in metres, 0 = no reading; raises UnusableFrame."""

    def instance_ids(self, index: int) -> Int32Array | None:
        """(h, w) on the grid of the recorded depth, 0 = nobody's; None where there are none; raises UnusableFrame."""
        return None

    def part_ids(self, index: int) -> Uint8Array | None:
        """(h, w) on the grid of the recorded depth, the part of its instance that a pixel shows, 0 = none; None where
        there are none; raises UnusableFrame."""
        return None

    def label(self, index: int, kind: str) -> str:
        """What messages call an image; kind is colour, depth, instance ids or parts."""
        return f"{kind} of frame {index}"

    def color_file(self, index: int) -> str:
        """The name of the file of a colour image, '' where images have none: other programs' poses go by it."""
        return ""


class ColorGridIds(Protocol):
    """Images of instance ids on the grid of colour; can be pickled."""

    def __call__(self, index: int, /) -> Uint16Array | None:
        """(H, W) of a frame, 0 = nobody's; None where there is none; raises UnusableFrame."""

    def label(self, index: int) -> str:
        """What messages call an image."""


@dataclass(frozen=True)
class RecordedSequence(FrameIteration):
    """The frames of an image source; pose_of is None for a recording without poses; color_ids are instance ids where
    the source itself has none on the grid of depth; frames that no camera can have taken are `implausible`, with the
    reason; poses are given as seen from `origin`, which pose_of knows nothing of. recorded_stamps: whether stamps are
    those of a clock; poses_note: what poses from elsewhere are, '' where they are the recording's own;
    camera_note: where guessed intrinsics come from, '' where they are no guess."""

    name: str
    images: ImageSource
    rgbd_alignment: RgbdAlignment
    depth_scale: float
    pose_of: PoseSource | None = None
    class_names: Mapping[int, str] = field(default_factory=dict)
    color_ids: ColorGridIds | None = None
    implausible: Mapping[int, str] = field(default_factory=dict)
    origin: Origin = HERE
    recorded_stamps: bool = False
    poses_note: str = ""
    camera_note: str = ""

    @property
    def intrinsics(self) -> Intrinsics:
        """The pinhole camera of every frame."""
        return self.rgbd_alignment.intrinsics

    @property
    def has_poses(self) -> bool:
        """Whether frames come with world_from_camera."""
        return self.pose_of is not None

    def __len__(self) -> int:
        return len(self.images)

    def __getitem__(self, index: int) -> Frame:
        """The frame at `index`; raises UnusableFrame with the reason, or IndexError past the end."""
        if not 0 <= index < len(self.images):
            raise IndexError(index)
        if index in self.implausible:
            raise UnusableFrame(self.implausible[index])
        # The pose comes first: a frame that has none need not be decoded.
        pose, notes = (None, ()) if self.pose_of is None else self._pose(self.pose_of, index)
        depth = self._depth(index)
        rgb = self.images.color(index)
        self._check_size(index, "colour", size_of(rgb), self.rgbd_alignment.color_size)
        rgb, has_color, recorded = self.rgbd_alignment.color(rgb, depth)
        ids = self._instance_ids(index, depth)
        names = self.class_names if ids is not None else {}
        stamp, parts = self.images.stamp(index), self._part_ids(index)
        return Frame(index, stamp, rgb, depth, self.intrinsics, pose, ids, names, notes, has_color, parts, recorded)

    def _pose(self, pose_of: PoseSource, index: int) -> PoseWithNotes:
        pose, notes = pose_of(index)
        return moved_origin(pose, self.origin), notes

    def _depth(self, index: int) -> Float32Array:
        depth = self.images.depth(index)
        self._check_size(index, "depth", size_of(depth), self.rgbd_alignment.depth_size)
        if not depth.any():
            raise UnusableFrame(f"{self.images.label(index, 'depth')} holds no valid depth")
        return self.rgbd_alignment.on_depth_grid(depth)

    def _instance_ids(self, index: int, depth: Float32Array) -> Int32Array | None:
        ids = self.images.instance_ids(index)
        if ids is None:
            drawn = None if self.color_ids is None else self.color_ids(index)
            if self.color_ids is None or drawn is None:
                return None
            return ids_on_depth_grid(drawn, self.rgbd_alignment, depth, self.color_ids.label(index))
        self._check_size(index, "instance ids", size_of(ids), self.rgbd_alignment.depth_size)
        return self.rgbd_alignment.on_depth_grid(ids.astype(np.float32)).astype(np.int32)

    def _part_ids(self, index: int) -> Uint8Array | None:
        parts = self.images.part_ids(index)
        if parts is None:
            return None
        self._check_size(index, "parts", size_of(parts), self.rgbd_alignment.depth_size)
        return self.rgbd_alignment.on_depth_grid(parts.astype(np.float32)).astype(np.uint8)

    def _check_size(self, index: int, kind: str, size: Size, expected: Size) -> None:
        if size != expected:
            label = self.images.label(index, kind)
            raise UnusableFrame(f"{label} is {size[0]}x{size[1]} where others are {expected[0]}x{expected[1]}")


def recorded_sequence(
    path: Path,
    images: ImageSource,
    declared: Declared,
    pose_of: PoseSource | None,
    *,
    name: str | None = None,
    depth_scale: float = 1.0,
    class_names: Mapping[int, str] | None = None,
    recorded_stamps: bool = False,
) -> RecordedSequence:
    """The sequence of an image source, with everything checked that one look at the recording can check.

    Args:
        path: what was opened, for messages.
        images: where the images come from.
        declared: the cameras, and how colour lies to depth.
        pose_of: where the poses come from; None = there are none.
        name: what to call the recording; None = the path without its suffix.
        depth_scale: units per metre in which depth is on disk.
        class_names: the class of each instance id.
        recorded_stamps: whether stamps are those of a clock, and not made up by the reader.

    Raises:
        BadInput: where the camera is unknown, colour and depth do not fit together, no pair can be read, or stamps and
            poses are those of no camera.
    """
    if not len(images):
        raise BadInput(f"{path} holds no frames")
    if declared.depth_camera is None:
        raise BadInput(f"{path} does not say what camera took it: give {HOW_TO_DECLARE}")
    color_size, depth_size = _image_sizes(path, images)
    try:
        rgbd_alignment = make_rgbd_alignment(declared, color_size, depth_size)
    except BadInput as error:
        raise BadInput(f"{path}: {error}") from None
    stamps = np.array([images.stamp(index) for index in range(len(images))], dtype=np.float64)
    positions = None if pose_of is None else positions_of(pose_of, len(images))
    return RecordedSequence(
        path.stem if name is None else name,
        images,
        rgbd_alignment,
        depth_scale,
        pose_of,
        dict(class_names or {}),
        implausible=implausible_frames(path, stamps, positions, recorded_stamps=recorded_stamps),
        origin=HERE if positions is None else local_origin(positions),
        recorded_stamps=recorded_stamps,
    )


def in_world(sequence: RgbdSequence) -> RgbdSequence:
    """The recording with its poses as they are written, and not as seen from a local origin."""
    return replace(sequence, origin=HERE) if isinstance(sequence, RecordedSequence) else sequence


def _image_sizes(path: Path, images: ImageSource) -> tuple[Size, Size]:
    """The commonest sizes of colour and depth over a few pairs spread over the recording."""
    counts: Counter[tuple[Size, Size]] = Counter()
    last_error = UnusableFrame("no frames")
    spread = np.linspace(0, len(images) - 1, _PROBES).round().astype(int)
    for i in dict.fromkeys([*spread.tolist(), *range(len(images))]):
        if counts.total() >= min(_PROBES, len(images)):
            break
        try:
            counts[size_of(images.color(i)), size_of(images.depth(i))] += 1
        except UnusableFrame as error:
            last_error = error
    if not counts:
        raise BadInput(f"{path} holds no usable frame; the last problem was: {last_error}")
    return counts.most_common(1)[0][0]
