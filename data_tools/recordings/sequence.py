"""The protocol of an RGB-D sequence: frames by index, read lazily, and iteration over those that can be used."""

from __future__ import annotations

import warnings
from collections.abc import Callable, Iterator
from typing import Protocol

from razer.errors import UnusableFrame
from razer.frame import Frame, Intrinsics


class IndexedFrames(Protocol):
    """Frames by index."""

    def __len__(self) -> int: ...

    def __getitem__(self, index: int, /) -> Frame:
        """The frame at `index`; raises UnusableFrame with the reason, or IndexError past the end."""


class RgbdSequence(IndexedFrames, Protocol):
    """A recording, read lazily and in any order."""

    @property
    def name(self) -> str:
        """What to call the recording."""

    @property
    def intrinsics(self) -> Intrinsics:
        """The pinhole camera of every frame."""

    @property
    def has_poses(self) -> bool:
        """Whether frames come with world_from_camera."""

    @property
    def depth_scale(self) -> float:
        """Declared depth units per metre of the files; 1 where depth is made in metres."""

    def __iter__(self) -> Iterator[Frame]:
        """The usable frames in order; each other one is a UserWarning with its index and the reason."""


class FrameIteration:
    """The iteration of RgbdSequence for classes that have their frames by index."""

    def __iter__(self: IndexedFrames) -> Iterator[Frame]:
        """The usable frames in order; each other one is a UserWarning with its index and the reason."""
        return usable_frames(self, _warn)


def usable_frames(sequence: IndexedFrames, report: Callable[[int, str], None]) -> Iterator[Frame]:
    """The frames that can be used, in order; `report` is called with index and reason of each other one."""
    for index in range(len(sequence)):
        try:
            frame = sequence[index]
        except UnusableFrame as error:
            report(index, str(error))
        else:
            yield frame


def _warn(index: int, reason: str) -> None:
    # Level 3 is the loop that iterates: below it are the generator and this function.
    warnings.warn(f"frame {index} is skipped: {reason}", UserWarning, stacklevel=3)
