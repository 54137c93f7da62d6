"""Sparse readings: a few of a frame's depths, far ones among them, with their colours, which are registered to depth as
far as the colour camera is known.
"""

from __future__ import annotations

from functools import lru_cache

import cv2
import numpy as np

from razer.arrays import BoolArray, Float16Array, Float64Array, Uint8Array
from razer.frame import Frame, Intrinsics
from slam.frontend.color_calibration import ColorCalibration

FARTHEST_M = float(np.finfo(np.float16).max)
UNREAD_M = 2.0  # at which a pixel without depth is taken to look
MOVED_PIXELS = 0.5  # by which colours must lie elsewhere, to be read there: between pixels they blur


def sparse_readings(frame: Frame, width: int) -> tuple[Float16Array, Uint8Array, Intrinsics]:
    """One depth, as it is, of every few pixels of a frame, about `width` across, the mean colour about each, and the
    camera that sees these alone. Depth is kept to a two-thousandth of itself."""
    k = frame.intrinsics
    step = max(1, round(k.width / width))
    first = step // 2
    depth = frame.depth[first::step, first::step].clip(max=FARTHEST_M).astype(np.float16)
    rgb = np.ascontiguousarray(cv2.blur(frame.rgb, (step, step))[first::step, first::step])
    middle = (k.cx - first) / step, (k.cy - first) / step
    return depth, rgb, Intrinsics(depth.shape[1], depth.shape[0], k.fx / step, k.fy / step, *middle)


@lru_cache(maxsize=8)
def pixel_rays(k: Intrinsics) -> Float64Array:
    """Directions x / z and y / z (2, H * W) of all pixels, rows one after the other; to be read only."""
    row, column = np.divmod(np.arange(k.height * k.width), k.width)
    return np.stack([(column - k.cx) / k.fx, (row - k.cy) / k.fy])


def color_offsets(k: Intrinsics, depth: Float16Array, calibration: ColorCalibration) -> Float64Array:
    """How far (h, w, 2) the colours of readings (h, w) lie from them on their grid, pixels."""
    rays = pixel_rays(k).T
    read_m = np.where(depth > 0, depth, UNREAD_M).ravel().astype(np.float64)
    moved: Float64Array = (calibration.color_rays(rays, read_m) - rays) * (k.fx, k.fy)
    return moved.reshape(k.height, k.width, 2)


def registered_colors(
    recorded_rgb: Uint8Array, k: Intrinsics, depth: Float16Array, calibration: ColorCalibration
) -> tuple[Uint8Array, BoolArray]:
    """Colours (h, w, 3) of readings, where the colour camera saw them, and which of them (h, w) it saw at all.

    Args:
        recorded_rgb: (h, w, 3) colours on the grid of the readings.
        k: the camera that sees this grid alone.
        depth: (h, w) the readings, metres.
        calibration: the colour camera.
    """
    moved = color_offsets(k, depth, calibration)
    if np.abs(moved).max() <= MOVED_PIXELS:
        return recorded_rgb, np.broadcast_to(np.True_, depth.shape)  # of one byte
    row, column = np.indices(depth.shape)
    at = (moved + np.stack([column, row], axis=2)).astype(np.float32)
    seen = np.all((at >= -0.5) & (at <= (k.width - 0.5, k.height - 0.5)), axis=2)
    rgb = cv2.remap(recorded_rgb, at, None, cv2.INTER_LINEAR, borderMode=cv2.BORDER_REPLICATE)
    return rgb.astype(np.uint8, copy=False), seen
