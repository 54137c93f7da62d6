"""A recording whose images are not plain image files: the frames of one archive, stream or bag."""

from __future__ import annotations

from collections import Counter
from dataclasses import dataclass
from pathlib import Path
from typing import Protocol

import numpy as np

from data_tools.recordings.camera import HOW_TO_DECLARE, Declared
from data_tools.recordings.images import size_of
from data_tools.recordings.rgbd_alignment import RgbdAlignment, Size, make_rgbd_alignment
from data_tools.recordings.trajectories import PoseSource
from razer.arrays import Float32Array, Uint8Array
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


@dataclass(frozen=True)
class SourceSequence:
    """A Sequence over the pairs of a source; pose_of is None for a recording without poses."""

    name: str
    source: ImageSource
    registration: RgbdAlignment
    depth_scale: float
    pose_of: PoseSource | None = None

    @property
    def intrinsics(self) -> Intrinsics:
        """The pinhole camera of every frame."""
        return self.registration.intrinsics

    @property
    def has_poses(self) -> bool:
        """Whether frames come with world_from_camera."""
        return self.pose_of is not None

    def __len__(self) -> int:
        return len(self.source)

    def __getitem__(self, index: int) -> Frame:
        """The frame at `index`; raises UnusableFrame with the reason, or IndexError past the end."""
        if not 0 <= index < len(self.source):
            raise IndexError(index)
        pose, notes = (None, ()) if self.pose_of is None else self.pose_of(index)
        depth = self.source.depth(index)
        _check_size("depth", size_of(depth), self.registration.depth_size)
        if not depth.any():
            raise UnusableFrame(f"frame {index} holds no valid depth")
        depth = self.registration.on_depth_grid(depth)
        rgb = self.source.color(index)
        _check_size("colour", size_of(rgb), self.registration.color_size)
        rgb = self.registration.color(rgb, depth)
        return Frame(index, self.source.stamp(index), rgb, depth, self.intrinsics, pose, notes=notes)


def source_sequence(
    path: Path, source: ImageSource, declared: Declared, pose_of: PoseSource | None, depth_scale: float = 1.0
) -> SourceSequence:
    """The sequence of a source whose depths are in `depth_scale` units a metre on disk; raises BadInput where the
    camera is unknown, colour and depth do not fit together, or no pair can be read."""
    if not len(source):
        raise BadInput(f"{path} holds no frames")
    if declared.depth_camera is None:
        raise BadInput(f"{path} does not say what camera took it: give {HOW_TO_DECLARE}")
    color_size, depth_size = _image_sizes(path, source)
    try:
        registration = make_rgbd_alignment(declared, color_size, depth_size)
    except BadInput as error:
        raise BadInput(f"{path}: {error}") from None
    return SourceSequence(path.stem, source, registration, depth_scale, pose_of)


def _image_sizes(path: Path, source: ImageSource) -> tuple[Size, Size]:
    """The commonest sizes of colour and depth over a few pairs spread over the recording."""
    found: Counter[tuple[Size, Size]] = Counter()
    last_error = UnusableFrame("no frames")
    spread = np.linspace(0, len(source) - 1, _PROBES).round().astype(int)
    for i in dict.fromkeys([*spread.tolist(), *range(len(source))]):
        if found.total() >= min(_PROBES, len(source)):
            break
        try:
            found[size_of(source.color(i)), size_of(source.depth(i))] += 1
        except UnusableFrame as error:
            last_error = error
    if not found:
        raise BadInput(f"{path} holds no usable frame; the last problem was: {last_error}")
    return found.most_common(1)[0][0]


def _check_size(what: str, size: Size, expected: Size) -> None:
    if size != expected:
        raise UnusableFrame(f"{what} is {size[0]}x{size[1]} where others are {expected[0]}x{expected[1]}")
