"""Hard walk: frames of a recording in an order of their own, some of them dark, with poses known exactly."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from typing import NamedTuple, Protocol

import numpy as np

from data_tools.recordings.sequence import IndexedFrames
from razer.arrays import Float64Array, Pose
from razer.frame import Frame, Intrinsics

Change = Callable[[Frame], Frame]


class PosedFrames(IndexedFrames, Protocol):
    """Frames by index, whose poses are known."""

    @property
    def poses(self) -> Float64Array:
        """world_from_camera (N, 4, 4)."""

    @property
    def intrinsics(self) -> Intrinsics:
        """The pinhole camera of every frame."""


@dataclass(frozen=True)
class JoinedFrames:
    """The frames of one recording, and then those of another one by the same camera."""

    first: PosedFrames
    second: PosedFrames

    @property
    def poses(self) -> Float64Array:
        """world_from_camera (N, 4, 4)."""
        return np.concatenate([self.first.poses, self.second.poses])

    @property
    def intrinsics(self) -> Intrinsics:
        """The pinhole camera of every frame."""
        return self.first.intrinsics

    def __len__(self) -> int:
        return len(self.first) + len(self.second)

    def __getitem__(self, index: int) -> Frame:
        within = index - len(self.first)
        return self.first[index] if within < 0 else replace(self.second[within], index=index)


class Shot(NamedTuple):
    """A frame as pose estimation is given it, without its pose, and that pose; None where the camera saw nothing."""

    frame: Frame
    world_from_camera: Pose | None


@dataclass(frozen=True)
class HardWalk:
    """What a camera shows on a walk.

    Args:
        recording: where the frames come from, which has their poses.
        order: which of its frames are shown one after the other; None = nothing is seen, as under a covered lens.
        frames_per_s: at which they are shown.
        change: what befalls each frame that shows something; its index is still that in the recording.
    """

    recording: PosedFrames
    order: tuple[int | None, ...]
    frames_per_s: float
    change: Change = lambda frame: frame

    def __len__(self) -> int:
        return len(self.order)

    def __iter__(self) -> Iterator[Shot]:
        """The shots, numbered and timed in the order in which they are shown, read as they are asked for."""
        for number, index in enumerate(self.order):
            frame = self._blind() if index is None else self.change(self.recording[index])
            pose = None if index is None else self.recording.poses[index]
            # Whoever estimates poses is given images alone.
            yield Shot(Frame(number, number / self.frames_per_s, frame.rgb, frame.depth, frame.intrinsics), pose)

    def _blind(self) -> Frame:
        camera = self.recording.intrinsics
        shape = (camera.height, camera.width)
        return Frame(0, 0.0, np.zeros((*shape, 3), np.uint8), np.zeros(shape, np.float32), camera)


def shuffled(walk: HardWalk, seed: int) -> HardWalk:
    """What a walk shows, in any order."""
    numbers = np.random.default_rng([seed, 103]).permutation(len(walk))
    return replace(walk, order=tuple(walk.order[number] for number in numbers.tolist()))


def to_and_fro(n: int) -> tuple[int, ...]:
    """An order in which the first quarter of n frames is shown four times, there and back and once more."""
    way = tuple(range(n // 4))
    return (*way, *way[::-1]) * 2


def dark(share: float, sigma: float, seed: int) -> Change:
    """Light that is no more than a share of what it was, under noise of sigma grey levels."""

    def change(frame: Frame) -> Frame:
        rng = np.random.default_rng([seed, 101, frame.index])
        grey_levels = share * frame.rgb + rng.normal(0, sigma, frame.rgb.shape)
        return replace(frame, rgb=np.rint(grey_levels).clip(0, 255).astype(np.uint8))

    return change
