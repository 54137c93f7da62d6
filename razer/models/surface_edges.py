"""How strongly neighbouring pixels are parted: by a depth step or by a concave crease."""

from __future__ import annotations

from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from razer.frame import Intrinsics
from razer.models.local_planes import Image, LocalPlanes

STRONGEST = 3.0


@dataclass(frozen=True, slots=True)
class EdgeLimits:
    """What counts as an edge of strength 1: a step of so many standard deviations of the noise (inverse depth,
    1/m), a crease of so many degrees. Convex creases mostly lie within one object, so they are allowed more."""

    noise_per_m: float
    step: float
    concave_deg: float
    convex_deg: float


def normals(planes: LocalPlanes, camera: Intrinsics) -> NDArray[np.float32]:
    """Unit normals (3, h, w) pointing away from the camera, from n . K^-1 (u, v, 1) = 1/z."""
    height, width = planes.value.shape
    u = np.arange(width, dtype=np.float32) - np.float32(camera.cx)
    v = (np.arange(height, dtype=np.float32) - np.float32(camera.cy))[:, None]
    x, y = planes.slope_x * np.float32(camera.fx), planes.slope_y * np.float32(camera.fy)
    z = planes.value - planes.slope_x * u - planes.slope_y * v
    length = 1 / np.sqrt(np.maximum(x * x + y * y + z * z, np.float32(1e-12)))
    return np.stack([x * length, y * length, z * length])


def edge_strengths(planes: LocalPlanes, camera: Intrinsics, limits: EdgeLimits) -> tuple[Image, Image]:
    """Strength in [0, STRONGEST] between each pixel and its right and its lower neighbour, each (h, w); from 1
    on it is an edge. Next to a pixel without a reading it is STRONGEST."""
    directions = normals(planes, camera)
    right = _strength(planes, directions, limits, 1)
    below = _strength(planes, directions, limits, 0)
    return right, below


def _strength(planes: LocalPlanes, directions: NDArray[np.float32], limits: EdgeLimits, axis: int) -> Image:
    def pair(image: NDArray) -> tuple[NDArray, NDArray]:
        return (image[..., :-1], image[..., 1:]) if axis == 1 else (image[..., :-1, :], image[..., 1:, :])

    (value, next_value), (valid, next_valid) = pair(planes.value), pair(planes.valid)
    slope, next_slope = pair(planes.slope_x if axis == 1 else planes.slope_y)
    # Both planes are asked for the inverse depth half way between the two pixels.
    step = np.abs(value - next_value + (slope + next_slope) * np.float32(0.5))
    step *= np.float32(1 / (limits.step * limits.noise_per_m))
    normal, next_normal = pair(directions)
    crease = np.sqrt(sum((a - b) ** 2 for a, b in zip(normal, next_normal, strict=True)))  # about the angle
    concave = next_slope > slope
    per_rad = np.where(
        concave, np.float32(1 / np.radians(limits.concave_deg)), np.float32(1 / np.radians(limits.convex_deg))
    )
    strength = np.minimum(np.maximum(step, crease * per_rad), np.float32(STRONGEST))
    strength[~(valid & next_valid)] = STRONGEST
    return np.pad(strength, ((0, 0), (0, 1)) if axis == 1 else ((0, 1), (0, 0)))
