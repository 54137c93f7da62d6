"""The camera of a picture: perspective or, for plans, orthographic; fitted to what it shows."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from razer.arrays import Float32Array, Float64Array, FloatArray

_DISTANCE_RADII = 4.0  # of the eye, in radii of the map: little foreshortening, but still perspective
_PARALLEL_M = 10_000.0  # farther, and depth in single precision is coarser than a millimetre
_RIM = 0.002  # share of points left and right that may lie outside the frame: fragments far off


@dataclass(frozen=True)
class PictureCamera:
    """Looks along `axes[2]` from `eye` (3,), metres; axes (3, 3): rows right, down, forward in the world.

    focal_px: pixels for a slope of 1, or for orthographic cameras for 1 metre; center_px (2,): where the axis through
    the eye meets the image; size (2,): width and height, pixels."""

    eye: Float64Array
    axes: Float64Array
    focal_px: float
    center_px: tuple[float, float]
    size: tuple[int, int]
    is_orthographic: bool = False

    def scaled(self, factor: int) -> PictureCamera:
        """The same view with `factor` times as many pixels along each side."""
        width, height = self.size
        center = (self.center_px[0] * factor, self.center_px[1] * factor)
        size = (width * factor, height * factor)
        return replace(self, focal_px=self.focal_px * factor, center_px=center, size=size)

    def towards_eye(self, points: FloatArray) -> Float64Array:
        """Vectors (N, 3) from points (N, 3) in the direction of the eye, of any length."""
        if self.is_orthographic:
            return np.broadcast_to(-self.axes[2], points.shape)
        return self.eye - points

    def project(self, points: FloatArray) -> Float64Array:
        """Pixels (N, 2), x and y, of points (N, 3)."""
        local = (points - self.eye) @ self.axes.T
        flat = local[:, :2] if self.is_orthographic else local[:, :2] / local[:, 2:]
        return self.focal_px * flat + np.array(self.center_px)

    @property
    def depth_focal_px(self) -> float:
        """The focal length that goes with `local` points."""
        return self.focal_px * (_PARALLEL_M if self.is_orthographic else 1.0)

    def local(self, points: FloatArray) -> Float32Array:
        """Points (N, 3) in the camera: right, down, forward, metres; for orthographic cameras from an eye so far behind
        that rays through the picture are parallel."""
        local = (points - self.eye) @ self.axes.T
        if self.is_orthographic:
            local[:, 2] += _PARALLEL_M
            local[:, :2] *= local[:, 2:] / _PARALLEL_M
        return local.astype(np.float32)

    def slant(self, first_row: int, last_row: int) -> Float64Array:
        """How much longer (rows, width) the rays through the pixels of some rows are than the depth that they reach."""
        if self.is_orthographic:
            return np.ones((last_row - first_row, self.size[0]))
        x = (np.arange(self.size[0]) + 0.5 - self.center_px[0]) / self.focal_px
        y = (np.arange(first_row, last_row) + 0.5 - self.center_px[1]) / self.focal_px
        return np.sqrt(1 + x**2 + y[:, None] ** 2)


def axes_towards(up: Float64Array, heading: Float64Array, elevation_deg: float) -> Float64Array:
    """Axes (3, 3) of a camera that stands in the horizontal direction `heading` (3,) of what it looks at, raised by an
    elevation of up to 90 degrees; `up` (3,) and `heading` are of unit length."""
    elevation = np.radians(elevation_deg)
    forward = -(np.cos(elevation) * heading + np.sin(elevation) * up)
    down = np.sin(elevation) * heading - np.cos(elevation) * up
    return np.stack([np.cross(down, forward), down, forward])


def fitted_camera(
    axes: Float64Array,
    points: FloatArray,
    size: tuple[int, int],
    margin_px: int,
    *,
    crops: bool = False,
    is_orthographic: bool = False,
) -> PictureCamera:
    """The camera that shows points (N, 3), N >= 1, as large as they fit.

    Args:
        axes: of the camera, as `axes_towards` gives them.
        points: what is to be in the picture, but for a few at its rim.
        size: width and height of the picture, pixels.
        margin_px: what stays free on each side.
        crops: the picture becomes smaller than `size` where the points leave a side of it empty.
        is_orthographic: parallel rays.
    """
    middle, radius = _ball(points)
    unit = PictureCamera(middle - _DISTANCE_RADII * radius * axes[2], axes, 1.0, (0.0, 0.0), size, is_orthographic)
    flat = unit.project(points)
    low, high = np.quantile(flat, [_RIM, 1 - _RIM], axis=0)
    extent = np.maximum(high - low, 1e-6 * radius)
    room = np.maximum(np.array(size) - 2 * margin_px, 1)
    focal = float((room / extent).min())
    shown = np.maximum(np.ceil(focal * extent).astype(int) + 2 * margin_px, 1) if crops else np.array(size)
    center = shown / 2 - focal * (low + high) / 2
    final = (min(int(shown[0]), size[0]), min(int(shown[1]), size[1]))
    return replace(unit, focal_px=focal, center_px=(float(center[0]), float(center[1])), size=final)


def _ball(points: FloatArray) -> tuple[Float64Array, float]:
    """Middle (3,) and radius of points, at least a millimetre."""
    low, high = np.quantile(np.asarray(points, np.float64), [_RIM, 1 - _RIM], axis=0)
    return (low + high) / 2, max(float(np.linalg.norm(high - low)) / 2, 1e-3)
