"""Edge strength between neighbouring pixels: depth steps, and concave or convex creases of the surface."""

from __future__ import annotations

from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from razer.arrays import Float32Array
from razer.frame import Intrinsics
from razer.models.geometric.local_planes import LocalPlanes

STRONGEST = 3.0

_BEND_WINDOW = (5, 5)  # pixels
_CREASE_SLACK = 1.0  # pixels


@dataclass(frozen=True, slots=True)
class EdgeLimits:
    """Edges of strength 1: a depth step of so many standard deviations of the noise (of inverse depth, 1/m), a crease
    of so many degrees. A convex crease mostly lies within one object."""

    noise_per_m: float
    step: float
    concave_deg: float
    convex_deg: float


def normals(planes: LocalPlanes, camera: Intrinsics) -> Float32Array:
    """Unit normals (3, h, w) pointing away from the camera: those n for which n . K^-1 (u, v, 1) ~ 1/z."""
    height, width = planes.value.shape
    u = np.arange(width, dtype=np.float32) - np.float32(camera.cx)
    v = (np.arange(height, dtype=np.float32) - np.float32(camera.cy))[:, None]
    x, y = planes.slope_x * np.float32(camera.fx), planes.slope_y * np.float32(camera.fy)
    z = planes.value - planes.slope_x * u - planes.slope_y * v
    length = 1 / np.sqrt(np.maximum(x * x + y * y + z * z, np.float32(1e-12)))
    return np.stack([x * length, y * length, z * length])


def edge_strengths(planes: LocalPlanes, camera: Intrinsics, limits: EdgeLimits) -> tuple[Float32Array, Float32Array]:
    """Strength in [0, STRONGEST] between each pixel and its right and its lower neighbour, each (h, w); from
    1 on it is an edge. Next to a pixel without depth it is STRONGEST, towards outside the image 0."""
    directions, per_rad = normals(planes, camera), _crease_weight(planes, limits)
    return _strength(planes, directions, per_rad, limits, 1), _strength(planes, directions, per_rad, limits, 0)


def _crease_weight(planes: LocalPlanes, limits: EdgeLimits) -> Float32Array:
    """Strength of a crease of one radian at each pixel, by whether the surface is concave or convex there.

    Inverse depth falls and then rises again across a concave crease: its Laplacian is positive, also after projection.
    Means over a few pixels are taken, because a pair of pixels along the crease shows none."""
    bend = np.zeros_like(planes.value)
    bend[:, :-1] += np.diff(planes.slope_x, axis=1)
    bend[:-1] += np.diff(planes.slope_y, axis=0)
    bend[~planes.valid] = 0
    concave, convex = 1 / np.radians(limits.concave_deg), 1 / np.radians(limits.convex_deg)
    return np.where(cv2.blur(bend, _BEND_WINDOW) > 0, np.float32(concave), np.float32(convex))


def _strength(
    planes: LocalPlanes, directions: Float32Array, per_rad: Float32Array, limits: EdgeLimits, axis: int
) -> Float32Array:
    def pair(image: NDArray) -> tuple[NDArray, NDArray]:
        return (image[..., :-1], image[..., 1:]) if axis == 1 else (image[..., :-1, :], image[..., 1:, :])

    (value, next_value), (valid, next_valid) = pair(planes.value), pair(planes.valid)
    slope, next_slope = pair(planes.slope_x if axis == 1 else planes.slope_y)
    # Both planes are evaluated half way between the two pixels. At a crease they differ by their difference of slope
    # for every pixel between that point and the crease: that is no step.
    step = np.abs(value - next_value + (slope + next_slope) * np.float32(0.5))
    step -= np.abs(next_slope - slope) * np.float32(_CREASE_SLACK)
    step *= np.float32(1 / (limits.step * limits.noise_per_m))
    (x, y, z), (next_x, next_y, next_z) = pair(directions)
    crease = np.sqrt((x - next_x) ** 2 + (y - next_y) ** 2 + (z - next_z) ** 2)  # the angle, nearly
    crease *= pair(per_rad)[0]
    strength = np.minimum(np.maximum(step, crease), np.float32(STRONGEST))
    strength[~(valid & next_valid)] = STRONGEST
    return np.pad(strength, ((0, 0), (0, 1)) if axis == 1 else ((0, 1), (0, 0)))
