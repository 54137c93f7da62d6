"""Pose sources: poses that came with the frames, or estimated ones, behind the same few methods."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Protocol

from razer.arrays import Pose
from razer.frame import Frame
from slam.report import PoseReport

__all__ = ["GivenPoses", "Pose", "Poses"]


class Poses(Protocol):
    """A source of poses."""

    def locate(self, frame: Frame) -> Pose | None:
        """world_from_camera (4, 4) of a frame, None = lost; raises UnusableFrame where the frame does not
        allow any answer."""

    def corrections(self) -> Mapping[int, Pose | None]:
        """Poses that changed since the last call, by frame index: the map must follow them. None = not known after
        all: what the frame showed must be removed."""

    def finish(self) -> None:
        """No more frames will come: the last corrections can be made."""

    def report(self) -> PoseReport | None:
        """What the estimation did since the last report; None where nothing is estimated."""


class GivenPoses:
    """The poses that the frames carry; they never change."""

    def locate(self, frame: Frame) -> Pose | None:
        """The frame's own pose; raises UnusableFrame where it has none."""
        return frame.pose

    def corrections(self) -> Mapping[int, Pose | None]:
        """Nothing: given poses are final."""
        return {}

    def finish(self) -> None:
        """Nothing is left to do."""

    def report(self) -> PoseReport | None:
        """Nothing: given poses are not estimated."""
        return None
