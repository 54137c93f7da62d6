"""The protocol of a recording: frames by index, read lazily."""

from __future__ import annotations

from typing import Protocol

from razer.frame import Frame, Intrinsics


class RgbdSequence(Protocol):
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

    def __len__(self) -> int: ...

    def __getitem__(self, index: int) -> Frame:
        """The frame at `index`; raises UnusableFrame with the reason, or IndexError past the end."""
