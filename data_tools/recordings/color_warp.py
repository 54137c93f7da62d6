"""Colour of a second camera, looked up through depth: each depth pixel's point is projected into the colour image."""

from __future__ import annotations

from dataclasses import dataclass, replace

import cv2
import numpy as np
from numpy.typing import NDArray

from data_tools.recordings.rgbd_calibration import RgbdCalibration
from razer.arrays import BoolArray, Float32Array, Int32Array, Uint8Array
from razer.frame import Frame, Intrinsics, RecordedColor

# What lies behind something nearer by more than this, in the colour camera's view, is hidden from it: what sensors err
# by and smooth surfaces span within a cell stays below.
_HIDDEN_SHARE, _HIDDEN_M = 0.02, 0.02
_NEAREST_M = 1e-3  # in front of the colour camera; what is behind it divides nothing
_GAP_STEP = 4  # gaps are filled from every fourth reading: what is seen there is not mapped
_CELL_SPACINGS = 1.5  # cells of the depth buffer, in distances between neighbouring points: none stays empty


@dataclass(frozen=True)
class RegisteredColor:
    """Colour (H, W, 3) uint8 on the grid of depth, black where the colour camera sees nothing of it; where it sees it,
    `is_seen` (H, W); and the picture it is from."""

    rgb: Uint8Array
    is_seen: BoolArray
    recorded: RecordedColor


@dataclass(frozen=True)
class ColorWarp:
    """The lookup of two pinhole cameras: pixel p with depth d lies at `rays` p * d + `shift` in homogeneous colour
    pixels, K_c (R K_d^-1 p d + t). cell_px: of the depth buffer, colour pixels."""

    rays: Float32Array
    shift: Float32Array
    cell_px: int = 2

    @classmethod
    def between(cls, depth: Intrinsics, calibration: RgbdCalibration) -> ColorWarp:
        """The tables of a depth camera and a colour camera beside it."""
        u, v = np.meshgrid(np.arange(depth.width), np.arange(depth.height))
        pixels = np.stack([u, v, np.ones_like(u)]).reshape(3, -1)
        color, rotation = calibration.color.matrix, calibration.color_from_depth[:3, :3]
        rays = color @ rotation @ np.linalg.inv(depth.matrix) @ pixels
        shift = color @ calibration.color_from_depth[:3, 3]
        spacing = max(calibration.color.fx / depth.fx, calibration.color.fy / depth.fy)
        return cls(
            rays.reshape(3, depth.height, depth.width).astype(np.float32),
            shift.reshape(3, 1, 1).astype(np.float32),
            max(2, int(np.ceil(_CELL_SPACINGS * spacing))),
        )

    def apply(self, rgb: Uint8Array, depth: Float32Array) -> RegisteredColor:
        """Colour on the grid of a depth image (H, W), metres. Pixels without depth take the nearest one's: 2D models
        look at whole pictures, and nothing is mapped there."""
        x, y, is_seen = self._lookup(_without_gaps(depth), depth > 0, (rgb.shape[1], rgb.shape[0]))
        colors = cv2.remap(rgb, x, y, cv2.INTER_LINEAR, borderMode=cv2.BORDER_REPLICATE)
        colors[~is_seen] = 0
        return RegisteredColor(colors, is_seen, RecordedColor(rgb, _nearest_pixel(x, y, rgb.shape)))

    def nearest(self, ids: NDArray, depth: Float32Array) -> NDArray:
        """Ids of the colour image on the grid of a depth image (H, W), metres: that of the nearest pixel, never one
        between two; 0 where there is no depth to look through, or the colour camera does not see it."""
        x, y, is_seen = self._lookup(depth, depth > 0, (ids.shape[1], ids.shape[0]))
        return np.where(is_seen & (depth > 0), cv2.remap(ids, x, y, cv2.INTER_NEAREST), 0)

    def _lookup(
        self, depth: Float32Array, measured: BoolArray, size: tuple[int, int]
    ) -> tuple[Float32Array, Float32Array, BoolArray]:
        """Colour pixels x and y of each depth pixel, and whether an image of that size (width, height) shows it;
        `measured` are those that hide others."""
        x, y, w = self.rays * depth + self.shift
        ahead = w > _NEAREST_M
        np.maximum(w, np.float32(_NEAREST_M), out=w)
        x /= w
        y /= w
        width, height = size
        inside = ahead & (x >= -0.5) & (y >= -0.5) & (x <= width - 0.5) & (y <= height - 0.5)
        return x, y, inside & ~_is_hidden(x, y, w, inside & measured, inside, size, self.cell_px)

    def registered(self, frame: Frame) -> Frame:
        """A frame with its colour brought onto its depth."""
        color = self.apply(frame.rgb, frame.depth)
        return replace(frame, rgb=color.rgb, has_color=color.is_seen, recorded_color=color.recorded)


def _nearest_pixel(x: Float32Array, y: Float32Array, shape: tuple[int, ...]) -> Int32Array:
    """The pixel of an image of that shape, row by row, at which each of some places lies."""
    height, width = shape[:2]
    row, column = (np.rint(np.clip(where, 0, end - 1)).astype(np.int32) for where, end in ((y, height), (x, width)))
    return row * np.int32(width) + column


def _without_gaps(depth: Float32Array) -> Float32Array:
    """Depth with a reading from nearby where there is none, looked for in a small image."""
    missing = depth <= 0
    if not missing.any() or missing.all():
        return np.where(missing, np.float32(1), depth)
    small = np.ascontiguousarray(depth[::_GAP_STEP, ::_GAP_STEP])
    if not small.any():
        return np.where(missing, np.median(depth[~missing]), depth)
    _, nearest = cv2.distanceTransformWithLabels(
        (small <= 0).astype(np.uint8), cv2.DIST_L2, 3, labelType=cv2.DIST_LABEL_PIXEL
    )
    reading_of_label = np.zeros(int(nearest.max()) + 1, np.float32)
    reading_of_label[nearest[small > 0]] = small[small > 0]
    filled = reading_of_label[nearest].repeat(_GAP_STEP, axis=0).repeat(_GAP_STEP, axis=1)
    return np.where(missing, filled[: depth.shape[0], : depth.shape[1]], depth)


def _is_hidden(
    x: Float32Array,
    y: Float32Array,
    w: Float32Array,
    seen: BoolArray,
    inside: BoolArray,
    size: tuple[int, int],
    cell_px: int,
) -> BoolArray:
    """Which points lie behind others in the colour camera, by a depth buffer of coarse cells; `seen` are those that
    hide others."""
    columns = -(-size[0] // cell_px) + 1
    per_px = np.float32(1 / cell_px)
    row, column = (((where + np.float32(0.5)) * per_px).astype(np.int32) for where in (y, x))
    cell = np.where(inside, row * columns + column, 0)
    nearest = np.full(columns * (-(-size[1] // cell_px) + 1), np.inf, np.float32)
    np.minimum.at(nearest, cell[seen], w[seen])
    return np.asarray(w > nearest[cell] * (1 + _HIDDEN_SHARE) + _HIDDEN_M)
