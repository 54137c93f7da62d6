"""Structured-light depth errors: noise, quantisation and dropout on images of metres (0 = no reading)."""

from __future__ import annotations

from functools import lru_cache

import cv2
import numpy as np
from numpy.typing import NDArray

from data_tools.synthetic.camera.noise_fields import normal, uniform, whole_normal
from razer.arrays import BoolArray, Float32Array, FloatArray, Int16Array
from razer.frame import Intrinsics

EDGE_JUMP = 0.05
"""Neighbours that differ by this share of their depth (at least by as many metres) are on two sides of an edge."""
GRAZING_DEG = (70.0, 85.0)
"""Between the line of sight and the surface's normal: where readings begin to fail, and where all do."""


def axial_sigma_m(depth_m: NDArray) -> NDArray:
    """Deviation along the optical axis, metres, of a surface that faces the camera: 0.0012 + 0.0019 (z - 0.4)^2
    (Nguyen, Izadi, Lovell: Modeling Kinect sensor noise, 3DIMPVT 2012)."""
    return 0.0012 + 0.0019 * (depth_m - 0.4) ** 2


def add_lateral_noise(depth: Float32Array, sigma_px: float, rng: np.random.Generator) -> Float32Array:
    """Each pixel reads its depth from a place that is off by sigma_px in u and v (z sigma_px / f metres)."""
    places = cv2.add(_grid(depth.shape), whole_normal((*depth.shape, 2), sigma_px, rng))
    return cv2.remap(depth, places, None, cv2.INTER_NEAREST, borderMode=cv2.BORDER_REPLICATE)


def add_axial_noise(depth: Float32Array, strength: float, rng: np.random.Generator) -> Float32Array:
    """Independent noise of `strength` times axial_sigma_m."""
    return depth + np.float32(strength) * axial_sigma_m(depth) * normal(depth.shape, rng)


def round_disparity(depth: Float32Array, step_per_m: float) -> Float32Array:
    """Inverse depth in whole steps: depths are dz = z^2 step_per_m apart, with step 1 / (8 f b) for a camera of focal
    length f in pixels and baseline b in metres that tells disparities of 1/8 pixel apart."""
    inverse = np.float32(step_per_m) * np.maximum(depth, np.float32(1e-3))
    steps = np.maximum(np.rint(np.reciprocal(inverse)), 1)
    return np.reciprocal(steps * np.float32(step_per_m)) * (depth > 0)


def round_depth(depth: Float32Array, step_m: float) -> Float32Array:
    """Depth in whole steps."""
    # In this order, as a float32 times 0.001 would not be the nearest one to a whole millimetre.
    return np.rint(depth * np.float32(1 / step_m)) / np.float32(1 / step_m)


def depth_edges(depth: Float32Array) -> BoolArray:
    """Whether depth jumps within a pixel's eight neighbours."""
    span = cv2.morphologyEx(depth, cv2.MORPH_GRADIENT, np.ones((3, 3), np.uint8))
    return span > np.float32(EDGE_JUMP) * np.maximum(depth, 1)


def grazing(depth: Float32Array, camera: Intrinsics) -> Float32Array:
    """How hopeless a reading is by the angle at which the ray meets the surface: 0 below GRAZING_DEG, 1 above.

    On a plane inverse depth is a x + b y + c over the rays (x, y, 1), and (a, b, c) is along the normal."""
    inverse = np.reciprocal(np.maximum(depth, np.float32(1e-3)))
    x, y = _rays(camera)
    a = np.float32(camera.fx) * _slope(inverse)
    b = np.float32(camera.fy) * _slope(inverse.T).T
    c = inverse - a * x - b * y
    squared_cosine = inverse**2 / ((a * a + b * b + c * c) * (x * x + y * y + 1))
    first, last = np.cos(np.radians(GRAZING_DEG)).astype(np.float32)
    return np.clip((first - np.sqrt(squared_cosine)) / (first - last), 0, 1)


def lose(depth: Float32Array, chance: FloatArray, rng: np.random.Generator) -> Float32Array:
    """Readings vanish with the given chance of each pixel."""
    return depth * (uniform(depth.shape, rng) >= chance)


def _slope(image: Float32Array) -> Float32Array:
    """Change per column, the smaller one of before and behind, so that a jump is not taken for a slope."""
    step = np.diff(image, axis=1)
    slope = np.empty_like(image)
    slope[:, 1:-1] = np.maximum(np.minimum(step[:, 1:], step[:, :-1]), 0)
    slope[:, 1:-1] += np.minimum(np.maximum(step[:, 1:], step[:, :-1]), 0)
    slope[:, :1], slope[:, -1:] = step[:, :1], step[:, -1:]
    return slope


def _rays(camera: Intrinsics) -> tuple[Float32Array, Float32Array]:
    x = (np.arange(camera.width, dtype=np.float32) - np.float32(camera.cx)) / np.float32(camera.fx)
    y = (np.arange(camera.height, dtype=np.float32) - np.float32(camera.cy)) / np.float32(camera.fy)
    return x, y[:, None]


@lru_cache(maxsize=2)
def _grid(shape: tuple[int, ...]) -> Int16Array:
    height, width = shape
    return np.stack(np.meshgrid(np.arange(width), np.arange(height)), axis=-1).astype(np.int16)
