"""Where the camera was: poses that came with the frames, or (later) estimated ones, behind two methods."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from razer.frame import Frame

Pose = NDArray[np.float64]


class Poses(Protocol):
    """A source of poses."""

    def locate(self, frame: Frame) -> Pose | None:
        """world_from_camera (4, 4) of a frame, None = lost; raises UnusableFrame where it cannot tell."""

    def corrections(self) -> Mapping[int, Pose]:
        """Poses that changed since the last call, by frame index: the map must follow them."""


class GivenPoses:
    """The poses that the frames carry; they never change."""

    def locate(self, frame: Frame) -> Pose | None:
        """The frame's own pose; raises UnusableFrame where it has none."""
        return frame.pose

    def corrections(self) -> Mapping[int, Pose]:
        """Nothing: given poses are final."""
        return {}
