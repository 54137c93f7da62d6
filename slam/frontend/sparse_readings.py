"""Sparse readings: a few of a frame's depths, far ones among them, with their colours, which are registered to depth as
far as the colour camera is known.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import lru_cache

import cv2
import numpy as np

from razer.arrays import BoolArray, Float16Array, Float64Array, Uint8Array
from razer.frame import Frame, Intrinsics
from slam.frontend.color_calibration import ColorCalibration

FARTHEST_M = float(np.finfo(np.float16).max)
UNREAD_M = 2.0  # at which a pixel without depth is taken to look
MOVED_PIXELS = 0.5  # by which colours must lie elsewhere, to be read there: between pixels they blur


@dataclass(frozen=True, eq=False)
class SparseReadings:
    """Readings on the pixel grid of a camera that sees these alone.

    Attributes:
        depth: (h, w) metres, kept to a two-thousandth of itself, 0 where there is none.
        rgb: (h, w, 3) the colours of the readings.
        has_color: (h, w) whether the colour camera saw them.
        recorded_rgb: (h, w, 3) the colours as they were recorded.
        recorded_has_color: (h, w) whether the colour camera saw all the pixels whose mean each of them is.
        intrinsics: of the grid.
    """

    depth: Float16Array
    rgb: Uint8Array
    has_color: BoolArray
    recorded_rgb: Uint8Array
    recorded_has_color: BoolArray
    intrinsics: Intrinsics

    @classmethod
    def of(cls, frame: Frame, width: int, calibration: ColorCalibration) -> SparseReadings:
        """One depth, as it is, of every few pixels of a frame, about `width` across, and the mean colour about each."""
        k = frame.intrinsics
        step = max(1, round(k.width / width))
        first = step // 2
        depth = frame.depth[first::step, first::step].clip(max=FARTHEST_M).astype(np.float16)
        rgb = np.ascontiguousarray(cv2.blur(frame.rgb, (step, step))[first::step, first::step])
        middle = (k.cx - first) / step, (k.cy - first) / step
        grid = Intrinsics(depth.shape[1], depth.shape[0], k.fx / step, k.fy / step, *middle)
        seen = np.broadcast_to(np.True_, depth.shape)  # of one byte
        if frame.has_color is not None:
            seen = cv2.erode(frame.has_color.astype(np.uint8), np.ones((step, step)))[first::step, first::step] > 0
        return cls(depth, rgb, seen, rgb, seen, grid).recolored(calibration)

    def recolored(self, calibration: ColorCalibration) -> SparseReadings:
        """The same with the colours of where a colour camera, as known now, saw the readings."""
        moved, k = self.color_offsets(calibration), self.intrinsics
        if np.abs(moved).max() <= MOVED_PIXELS:
            return replace(self, rgb=self.recorded_rgb, has_color=self.recorded_has_color)
        row, column = np.indices(self.depth.shape)
        at = (moved + np.stack([column, row], axis=2)).astype(np.float32)
        seen = np.all((at >= -0.5) & (at <= (k.width - 0.5, k.height - 0.5)), axis=2)
        rgb = cv2.remap(self.recorded_rgb, at, None, cv2.INTER_LINEAR, borderMode=cv2.BORDER_REPLICATE)
        if not self.recorded_has_color.all():
            mixed = self.recorded_has_color.astype(np.float32)
            seen &= cv2.remap(mixed, at, None, cv2.INTER_LINEAR, borderMode=cv2.BORDER_REPLICATE) == 1
        return replace(self, rgb=rgb.astype(np.uint8, copy=False), has_color=seen)

    def color_offsets(self, calibration: ColorCalibration) -> Float64Array:
        """How far (h, w, 2) the colours of the readings lie from them on their grid, pixels."""
        k = self.intrinsics
        rays = pixel_rays(k).T
        read_m = np.where(self.depth > 0, self.depth, UNREAD_M).ravel().astype(np.float64)
        moved: Float64Array = (calibration.color_rays(rays, read_m) - rays) * (k.fx, k.fy)
        return moved.reshape(k.height, k.width, 2)

    def without(self, pixels: BoolArray) -> SparseReadings:
        """The same without those at some pixels (h, w)."""
        return replace(self, depth=np.where(pixels, np.float16(0), self.depth))


@lru_cache(maxsize=8)
def pixel_rays(k: Intrinsics) -> Float64Array:
    """Directions x / z and y / z (2, H * W) of all pixels, rows one after the other; to be read only."""
    row, column = np.divmod(np.arange(k.height * k.width), k.width)
    return np.stack([(column - k.cx) / k.fx, (row - k.cy) / k.fy])
