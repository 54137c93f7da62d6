"""Rendering by two cameras: depth and instance ids by one, colour by another beside it."""

from __future__ import annotations

from collections.abc import Callable
from typing import Protocol

import open3d as o3d

from data_tools.truth.rgbd_calibration import RgbdCalibration
from razer.arrays import Float32Array, Float64Array, Int32Array, Uint8Array
from razer.frame import Intrinsics
from razer.geometry import inverse


class Renderer(Protocol):
    """Images of a fixed world from any pose."""

    scene: o3d.t.geometry.RaycastingScene

    def render(self, world_from_camera: Float64Array) -> tuple[Uint8Array, Float32Array, Int32Array]:
        """The (H, W, 3) uint8 colour, (H, W) float32 depth in metres (0 = nothing) and (H, W) int32 instances."""


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

    def render(self, world_from_camera: Float64Array) -> tuple[Uint8Array, Float32Array, Int32Array]:
        """What the depth camera at this pose and the colour camera beside it see, as Renderer.render says."""
        _, depth, ids = self._depth.render(world_from_camera)
        rgb, _, _ = self._color.render(world_from_camera @ self._depth_from_color)
        return rgb, depth, ids
