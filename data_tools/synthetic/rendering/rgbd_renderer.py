"""Rendering by two cameras: depth and instance ids by one, colour by another beside it."""

from __future__ import annotations

from collections.abc import Callable
from typing import Protocol

from data_tools.recordings.rgbd_calibration import RgbdCalibration
from data_tools.synthetic.rendering.rendering import Rendering
from data_tools.synthetic.truth.visibility import Occluder
from razer.arrays import Float64Array
from razer.frame import Intrinsics
from razer.geometry import inverse


class Renderer(Protocol):
    """Images of a fixed world from any pose."""

    @property
    def scene(self) -> Occluder:
        """What hides one thing behind another."""

    def render(self, world_from_camera: Float64Array) -> Rendering:
        """What the camera at this pose sees."""


class RgbdRenderer:
    """Renders depth and instance ids from a pose, and colour from the colour camera beside it.

    Args:
        make: makes the renderer of a camera.
        depth: the depth camera.
        calibration: the colour camera.
    """

    def __init__(self, make: Callable[[Intrinsics], Renderer], depth: Intrinsics, calibration: RgbdCalibration) -> None:
        self._depth, self._color = make(depth), make(calibration.color)
        self._depth_from_color = inverse(calibration.color_from_depth)
        self.scene = self._depth.scene

    def render(self, world_from_camera: Float64Array) -> Rendering:
        """What the depth camera at this pose and the colour camera beside it see, as Renderer.render says."""
        seen = self._depth.render(world_from_camera)
        return seen._replace(rgb=self._color.render(world_from_camera @ self._depth_from_color).rgb)
