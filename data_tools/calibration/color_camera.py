"""Colour-camera model of an RGB-D pair: zoom, shift, baseline and roll against the depth camera."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from data_tools.recordings.rgbd_calibration import RgbdCalibration
from razer.arrays import Float64Array, FloatArray
from razer.frame import Intrinsics

N_PARAMETERS = 7
"""Zoom; shift x and y in pixels; baseline x, y and z in metres; roll in radians."""
REGISTERED = np.array([1.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0])
"""Parameters of a colour camera that is the depth camera."""


@dataclass(frozen=True)
class ColorProjection:
    """Points of a depth camera seen by a colour camera beside it, which looks the same way.

    A point of the depth camera at ray (x, y) and inverse depth w lies at
    zoom f R ((x, y) - (b_x, b_y) w) / (1 - b_z w) + c in colour, where b is the colour camera's place, R the roll about
    its axis, and c the principal point, zoomed about the middle of the image and shifted. Two cameras that look a
    little up or aside from each other differ by a shift, but for less than a pixel.
    """

    depth_camera: Intrinsics

    def pixels(self, parameters: Float64Array, rays: FloatArray, inverse_depth: FloatArray) -> Float64Array:
        """Colour pixels (N, 2) of rays (N, 2) at inverse depths (N,), 1/m."""
        camera = self.depth_camera
        x, y = self._seen(parameters, rays, inverse_depth)
        cx, cy = self._principal_point(parameters)
        return np.stack([parameters[0] * camera.fx * x + cx, parameters[0] * camera.fy * y + cy], axis=1)

    def jacobian(self, parameters: Float64Array, rays: FloatArray, inverse_depth: FloatArray) -> Float64Array:
        """Derivatives (N, 2, 7) of `pixels` by the parameters."""
        camera, zoom = self.depth_camera, parameters[0]
        x, y = self._seen(parameters, rays, inverse_depth)
        cos, sin = np.cos(parameters[6]), np.sin(parameters[6])
        middle_x, middle_y = _middle(camera)
        nearness = inverse_depth / (1 - parameters[5] * inverse_depth)
        result = np.zeros((len(rays), 2, N_PARAMETERS))
        result[:, 0, 0] = camera.fx * x + camera.cx - middle_x
        result[:, 1, 0] = camera.fy * y + camera.cy - middle_y
        result[:, 0, 1] = result[:, 1, 2] = 1.0
        result[:, 0, 3], result[:, 0, 4] = -zoom * camera.fx * cos * nearness, zoom * camera.fx * sin * nearness
        result[:, 1, 3], result[:, 1, 4] = -zoom * camera.fy * sin * nearness, -zoom * camera.fy * cos * nearness
        result[:, 0, 5], result[:, 1, 5] = zoom * camera.fx * x * nearness, zoom * camera.fy * y * nearness
        result[:, 0, 6], result[:, 1, 6] = -zoom * camera.fx * y, zoom * camera.fy * x
        return result

    def calibration(self, parameters: Float64Array) -> RgbdCalibration:
        """The same as a camera and a transform."""
        camera, zoom = self.depth_camera, float(parameters[0])
        cx, cy = self._principal_point(parameters)
        color = Intrinsics(camera.width, camera.height, zoom * camera.fx, zoom * camera.fy, float(cx), float(cy))
        color_from_depth = np.eye(4)
        color_from_depth[:2, :2] = _turn(parameters[6])
        color_from_depth[:3, 3] = -color_from_depth[:3, :3] @ parameters[3:6]
        return RgbdCalibration(color, color_from_depth)

    def view_grid(self) -> Float64Array:
        """Rays (63, 2) spread over the image, corners included."""
        camera = self.depth_camera
        u, v = np.meshgrid(np.linspace(0, camera.width - 1, 9), np.linspace(0, camera.height - 1, 7))
        return np.stack([(u - camera.cx) / camera.fx, (v - camera.cy) / camera.fy], axis=-1).reshape(-1, 2)

    def displacement_px(self, a: Float64Array, b: Float64Array, depths_m: FloatArray) -> Float64Array:
        """How far apart (D, 63) two colour cameras see what lies on the grid of rays at D depths, pixels."""
        rays = self.view_grid()
        apart = [self.pixels(a, rays, near) - self.pixels(b, rays, near) for near in self._planes(depths_m)]
        return np.linalg.norm(apart, axis=2)

    def sigma_px(self, parameters: Float64Array, covariance: Float64Array, depths_m: FloatArray) -> Float64Array:
        """Standard deviation (D, 63) of where the grid is seen, for parameters of covariance (7, 7), pixels."""
        rays = self.view_grid()
        jacobians = np.stack([self.jacobian(parameters, rays, near) for near in self._planes(depths_m)])
        return np.sqrt(np.einsum("dnij,jk,dnik->dn", jacobians, covariance, jacobians))

    def _planes(self, depths_m: FloatArray) -> list[Float64Array]:
        return [np.full(len(self.view_grid()), 1 / depth) for depth in depths_m.tolist()]

    def _seen(
        self, parameters: Float64Array, rays: FloatArray, inverse_depth: FloatArray
    ) -> tuple[Float64Array, Float64Array]:
        scale = 1 / (1 - parameters[5] * inverse_depth)
        moved = (rays - parameters[3:5] * inverse_depth[:, None]) * scale[:, None]
        x, y = (moved @ _turn(parameters[6]).T).T
        return x, y

    def _principal_point(self, parameters: Float64Array) -> tuple[float, float]:
        camera, zoom = self.depth_camera, parameters[0]
        middle_x, middle_y = _middle(camera)
        return (
            middle_x + zoom * (camera.cx - middle_x) + parameters[1],
            middle_y + zoom * (camera.cy - middle_y) + parameters[2],
        )


def _turn(roll_rad: float) -> Float64Array:
    cos, sin = np.cos(roll_rad), np.sin(roll_rad)
    return np.array([[cos, -sin], [sin, cos]])


def _middle(camera: Intrinsics) -> tuple[float, float]:
    return (camera.width - 1) / 2, (camera.height - 1) / 2
