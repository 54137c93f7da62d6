"""The plane through every pixel's surroundings, fitted where the surroundings are one plane.

The inverse depth of a plane is linear in the image, and the noise of a stereo or structured-light camera is
constant in inverse depth. So planes are fitted there, by least squares in square windows. Windows that
contain the pixel but are centred elsewhere compete too, and the one whose residual is least wins: up to a
depth step or a crease from either side, planes stay those of their own side.
"""

from __future__ import annotations

from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

Image = NDArray[np.float32]

_RADII = (2, 6)  # pixels; the small window is for cups and slats, the large one for calm walls
_SMALLER_WINDOW = 1.0  # what the small window must gain, in variances of the noise
_SHIFTED_WINDOW = 0.3  # what a window centred elsewhere must gain
_CALM = 1.3  # residuals below this many variances are all as good
_MIN_FILL = 0.4  # share of a window that needs a reading
_MIN_SPREAD = 0.15  # least determinant of the readings' scatter, as a share of the full window's
_COST_STEPS, _COST_LIMIT, _CANDIDATES = 4096, 1000, 32  # costs as integers, the candidate in the last digit


@dataclass(frozen=True, slots=True)
class LocalPlanes:
    """Inverse depth around each pixel: value + slope_x dx + slope_y dy; all (h, w) float32, 1/m and 1/m
    per pixel. Meaningful only where `valid`."""

    value: Image
    slope_x: Image
    slope_y: Image
    valid: NDArray[np.bool_]


def inverse_depth(depth_m: Image, factor: int, noise_per_m: float) -> Image:
    """Mean inverse depth of each factor x factor block of an (H, W) depth image, 0 where nothing was read.

    A block on a depth step takes its nearest surface only: a mean over both would float between them."""
    height, width = (size // factor * factor for size in depth_m.shape)
    inverse = cv2.divide(1.0, np.ascontiguousarray(depth_m[:height, :width]))
    inverse[depth_m[:height, :width] <= 0] = 0
    parts = [
        np.ascontiguousarray(inverse[i::factor, j::factor]) for i in range(factor) for j in range(factor)
    ]
    nearest = np.maximum.reduce(parts) - np.float32(7 * noise_per_m)
    total, count = np.zeros_like(nearest), np.zeros_like(nearest)
    for part in parts:
        same_surface = ((part > nearest) & (part > 0)).astype(np.float32)
        total += part * same_surface
        count += same_surface
    return total / np.maximum(count, 1)


def fit_local_planes(inverse: Image, noise_per_m: float) -> LocalPlanes:
    """The plane at each pixel of an (h, w) inverse depth image (0 = none) with the given noise, 1/m."""
    height, width = inverse.shape
    best = np.full(inverse.shape, np.iinfo(np.int32).max, np.int32)
    fits, offsets = [], []
    for scale, radius in enumerate(_RADII):
        slope_x, slope_y, value, variance = _fit_windows(inverse, radius)
        fits.append((slope_x, slope_y, value))
        cost = np.minimum(np.maximum(variance / np.float32(noise_per_m**2), _CALM), _COST_LIMIT)
        cost += np.float32(_SMALLER_WINDOW * (len(_RADII) - 1 - scale))
        ranked = _padded((cost * _COST_STEPS).astype(np.int32) * _CANDIDATES, radius)
        for dy, dx in [(i, j) for i in (0, -radius, radius) for j in (0, -radius, radius)]:
            shifted = ranked[radius + dy : radius + dy + height, radius + dx : radius + dx + width]
            handicap = int(_SHIFTED_WINDOW * _COST_STEPS) * _CANDIDATES if dx or dy else 0
            np.minimum(best, shifted + np.int32(handicap + len(offsets)), out=best)
            offsets.append((scale, dy, dx))
    return _chosen(best & (_CANDIDATES - 1), fits, offsets, inverse)


def _padded(ranked: NDArray[np.int32], radius: int) -> NDArray[np.int32]:
    limit = _COST_LIMIT * _COST_STEPS * _CANDIDATES
    return np.pad(ranked, radius, constant_values=limit)


def _chosen(
    candidate: NDArray[np.int32],
    fits: list[tuple[Image, ...]],
    offsets: list[tuple[int, int, int]],
    inverse: Image,
) -> LocalPlanes:
    """The winning window's plane, evaluated at the pixel itself."""
    height, width = inverse.shape
    scale, dy, dx = np.array(offsets, np.int32).T
    source = np.arange(height * width, dtype=np.int32).reshape(height, width)
    source += ((scale * height + dy) * width + dx).astype(np.int32).take(candidate)
    slope_x, slope_y, value = (
        np.concatenate([fit[part].ravel() for fit in fits]).take(source, mode="clip") for part in range(3)
    )
    value -= slope_x * dx.astype(np.float32).take(candidate)
    value -= slope_y * dy.astype(np.float32).take(candidate)
    return LocalPlanes(value, slope_x, slope_y, inverse > 0)


def _fit_windows(inverse: Image, radius: int) -> tuple[Image, Image, Image, Image]:
    """Slopes, value at the centre and residual variance of the plane in each pixel's window; the variance is
    infinite where too few readings pin it down."""
    step = np.arange(-radius, radius + 1, dtype=np.float32)
    one = np.ones_like(step)

    def mean(image: Image, kernel_x: Image, kernel_y: Image) -> Image:
        total: Image = cv2.sepFilter2D(image, -1, kernel_x, kernel_y, borderType=cv2.BORDER_CONSTANT)
        total *= share
        return total

    read = (inverse > 0).astype(np.float32)
    share = np.float32(1)
    count = mean(read, one, one)
    share = 1 / np.maximum(count, 1)
    x, y, w = mean(read, step, one), mean(read, one, step), mean(inverse, one, one)
    xx, yy = mean(read, step * step, one) - x * x, mean(read, one, step * step) - y * y
    xy = mean(read, step, step) - x * y
    xw, yw = mean(inverse, step, one) - x * w, mean(inverse, one, step) - y * w
    ww = mean(inverse * inverse, one, one) - w * w
    determinant = xx * yy - xy * xy
    full = radius * (radius + 1) / 3
    pinned = (count >= _MIN_FILL * (2 * radius + 1) ** 2) & (determinant > _MIN_SPREAD * full * full)
    scale = 1 / np.maximum(determinant, np.float32(1e-3))
    slope_x, slope_y = (yy * xw - xy * yw) * scale, (xx * yw - xy * xw) * scale
    variance = ww - slope_x * xw - slope_y * yw
    variance[~pinned] = np.inf
    return slope_x, slope_y, w - slope_x * x - slope_y * y, variance
