"""Local plane fitting in inverse depth, with shifted windows that keep depth steps and creases sharp.

The inverse depth of a plane is linear in the image, and the noise of a stereo or structured-light camera is
constant in inverse depth. So planes are fitted there, by least squares in square windows. Windows that
contain the pixel but are centred elsewhere compete too, and the one with the smallest residual wins: up to a
depth step or a crease from either side, planes stay those of their own side.
"""

from __future__ import annotations

from dataclasses import dataclass

import cv2
import numpy as np

from razer.arrays import BoolArray, Float32Array, Int32Array

_RADII = (2, 6)  # pixels; the small window is for cups and slats, the large one for even walls
_SMALLER_WINDOW = 1.0  # what the small window must gain, in variances of the noise
_SHIFTED_WINDOW = 0.3  # what a window centred elsewhere must gain
_NOISE_FLOOR = 1.3  # variances; smaller residuals do not rank a window higher
_MIN_FILL = 0.4  # share of a window that needs a reading
_MIN_SPREAD = 0.15  # lowest determinant of the readings' scatter, as a share of the full window's
_SAME_SURFACE = 5.5  # spread of one surface's readings within a block, in standard deviations

# A window's rank is one whole number: its cost in steps, then its place in the order of trial.
_COST_STEPS, _COST_LIMIT, _TRIALS = 4096, 1000, 32


@dataclass(frozen=True, slots=True)
class LocalPlanes:
    """Inverse depth around each pixel: value + slope_x dx + slope_y dy; all (h, w) float32, 1/m and 1/m
    per pixel. Meaningful only where `valid`."""

    value: Float32Array
    slope_x: Float32Array
    slope_y: Float32Array
    valid: BoolArray


@dataclass(frozen=True, slots=True)
class _WindowFits:
    """The least-squares plane of the window centred at each pixel, its value there, and its mean squared
    residual, infinite where the readings do not determine the plane."""

    value: Float32Array
    slope_x: Float32Array
    slope_y: Float32Array
    variance: Float32Array


def inverse_depth(depth_m: Float32Array, factor: int, noise_per_m: float) -> Float32Array:
    """Mean inverse depth of each factor x factor block of an (H, W) depth image, 0 where there is no depth.

    A block on a depth step takes its nearest surface only: a mean over both would float between them."""
    height, width = (size // factor * factor for size in depth_m.shape)
    depth_m = np.ascontiguousarray(depth_m[:height, :width])
    inverse = cv2.divide(1.0, depth_m)
    inverse[depth_m <= 0] = 0
    parts = [np.ascontiguousarray(inverse[i::factor, j::factor]) for i in range(factor) for j in range(factor)]
    far_limit = np.maximum.reduce(parts) - np.float32(_SAME_SURFACE * noise_per_m)
    total, count = np.zeros_like(far_limit), np.zeros_like(far_limit)
    for part in parts:
        same_surface = ((part > far_limit) & (part > 0)).astype(np.float32)
        total += part * same_surface
        count += same_surface
    return total / np.maximum(count, 1)


def fit_local_planes(inverse: Float32Array, noise_per_m: float) -> LocalPlanes:
    """The plane at each pixel of an (h, w) inverse depth image (0 = none) whose noise has the given
    standard deviation, 1/m."""
    height, width = inverse.shape
    best = np.full(inverse.shape, np.iinfo(np.int32).max, np.int32)
    fits = [_fit_windows(inverse, radius) for radius in _RADII]
    offsets: list[tuple[int, int, int]] = []
    for scale, radius in enumerate(_RADII):
        cost = np.clip(fits[scale].variance / np.float32(noise_per_m**2), _NOISE_FLOOR, _COST_LIMIT)
        cost += np.float32(_SMALLER_WINDOW * (len(_RADII) - 1 - scale))
        ranks = np.pad(_rank(cost), radius, constant_values=int(_rank(_COST_LIMIT)))
        for dy, dx in [(i, j) for i in (0, -radius, radius) for j in (0, -radius, radius)]:
            shifted = ranks[radius + dy : radius + dy + height, radius + dx : radius + dx + width]
            np.minimum(best, shifted + (_rank(_SHIFTED_WINDOW if dx or dy else 0) + len(offsets)), out=best)
            offsets.append((scale, dy, dx))
    return _winning_planes(best & (_TRIALS - 1), fits, offsets, inverse)


def _rank(cost: Float32Array | float) -> Int32Array:
    return (np.asarray(cost) * _COST_STEPS).astype(np.int32) * np.int32(_TRIALS)


def _winning_planes(
    trial: Int32Array, fits: list[_WindowFits], offsets: list[tuple[int, int, int]], inverse: Float32Array
) -> LocalPlanes:
    """The winning window's plane, evaluated at the pixel itself."""
    height, width = inverse.shape
    scale, dy, dx = np.array(offsets, np.int32).T
    source = np.arange(height * width, dtype=np.int32).reshape(height, width)
    source += ((scale * height + dy) * width + dx).astype(np.int32).take(trial)
    slope_x, slope_y, value = (
        np.concatenate([getattr(fit, part).ravel() for fit in fits]).take(source, mode="clip")
        for part in ("slope_x", "slope_y", "value")
    )
    value -= slope_x * dx.astype(np.float32).take(trial)
    value -= slope_y * dy.astype(np.float32).take(trial)
    return LocalPlanes(value, slope_x, slope_y, inverse > 0)


def _fit_windows(inverse: Float32Array, radius: int) -> _WindowFits:
    step = np.arange(-radius, radius + 1, dtype=np.float32)
    one, square = np.ones_like(step), step * step
    has_depth = (inverse > 0).astype(np.float32)
    count = _windowed(has_depth, one, one)
    share: Float32Array = np.reciprocal(np.maximum(count, np.float32(1)))
    x, y = _windowed(has_depth, step, one) * share, _windowed(has_depth, one, step) * share
    xx = _windowed(has_depth, square, one) * share - x * x
    yy = _windowed(has_depth, one, square) * share - y * y
    xy = _windowed(has_depth, step, step) * share - x * y
    mean = _windowed(inverse, one, one) * share
    xw = _windowed(inverse, step, one) * share - x * mean
    yw = _windowed(inverse, one, step) * share - y * mean
    ww = _windowed(inverse * inverse, one, one) * share - mean * mean
    determinant = xx * yy - xy * xy
    full = (radius * (radius + 1) / 3) ** 2
    is_determined = (count >= _MIN_FILL * (2 * radius + 1) ** 2) & (determinant > _MIN_SPREAD * full)
    determinant = np.maximum(determinant, np.float32(1e-3))
    slope_x, slope_y = (yy * xw - xy * yw) / determinant, (xx * yw - xy * xw) / determinant
    variance = ww - slope_x * xw - slope_y * yw
    variance[~is_determined] = np.inf
    return _WindowFits(mean - slope_x * x - slope_y * y, slope_x, slope_y, variance)


def _windowed(image: Float32Array, kernel_x: Float32Array, kernel_y: Float32Array) -> Float32Array:
    return cv2.sepFilter2D(image, -1, kernel_x, kernel_y, borderType=cv2.BORDER_CONSTANT)
