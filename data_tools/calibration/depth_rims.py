"""Depth discontinuities of an image: the rims of near things before far ones, with their normals."""

from __future__ import annotations

from dataclasses import dataclass

import cv2
import numpy as np

from razer.arrays import Float32Array, Float64Array
from razer.frame import Frame

JUMP = 1.06  # ratio of depths across a rim
SHADOW = 31 / 640  # share of the width: gaps beside near things, where projector and camera see differently
MAX_PER_FRAME = 800  # more of one image say little more
_BORDER = 4
_MIN_GRADIENT = 1e-3  # of log depth a pixel: less gives no normal


@dataclass(frozen=True)
class DepthRims:
    """N rim points of one image: rays (N, 2), inverse_depth (N,) 1/m of the near side, and normals (N, 2), unit
    vectors in the image that point to the far side."""

    rays: Float64Array
    inverse_depth: Float64Array
    normals: Float64Array

    def __len__(self) -> int:
        return len(self.rays)

    def thinned(self, step: int) -> DepthRims:
        """Every step-th of them."""
        return DepthRims(self.rays[::step], self.inverse_depth[::step], self.normals[::step])


def find_depth_rims(frame: Frame) -> DepthRims:
    """The rims in a frame's depth; of many, MAX_PER_FRAME drawn at random, the same each time."""
    camera = frame.intrinsics
    depth = np.where(frame.depth > 0, cv2.medianBlur(frame.depth, 3), np.float32(0))
    filled = _without_shadows(depth)
    behind = cv2.dilate(filled, np.ones((3, 3), np.uint8))
    is_rim = (depth > 0) & (behind > JUMP * depth)
    is_rim[:_BORDER] = is_rim[-_BORDER:] = is_rim[:, :_BORDER] = is_rim[:, -_BORDER:] = False
    rows, columns = np.nonzero(is_rim)
    if len(rows) > MAX_PER_FRAME:
        chosen = np.random.default_rng(frame.index).choice(len(rows), MAX_PER_FRAME, replace=False)
        rows, columns = rows[chosen], columns[chosen]
    gradient = _log_gradient(filled, rows, columns)
    steepness = np.linalg.norm(gradient, axis=1)
    clear = steepness > _MIN_GRADIENT
    rows, columns, normals = rows[clear], columns[clear], gradient[clear] / steepness[clear, None]
    # The border runs between the near pixel and its far neighbour.
    u, v = columns + 0.5 * normals[:, 0], rows + 0.5 * normals[:, 1]
    rays = np.stack([(u - camera.cx) / camera.fx, (v - camera.cy) / camera.fy], axis=1)
    return DepthRims(rays, 1 / depth[rows, columns].astype(np.float64), normals)


def _without_shadows(depth: Float32Array) -> Float32Array:
    """Depth whose gaps along a row take the farther of the readings at their ends: a shadow lies on what is behind."""
    width = depth.shape[1]
    column = np.arange(width)
    before = np.maximum.accumulate(np.where(depth > 0, column, -width), axis=1)
    after = np.minimum.accumulate(np.where(depth > 0, column, 2 * width)[:, ::-1], axis=1)[:, ::-1]
    is_shadow = (depth <= 0) & (after - before <= SHADOW * width + 1)
    ends = (np.take_along_axis(depth, index.clip(0, width - 1), axis=1) for index in (before, after))
    return np.where(is_shadow, np.maximum(*ends), depth)


def _log_gradient(filled: Float32Array, rows: np.ndarray, columns: np.ndarray) -> Float64Array:
    logarithm = cv2.GaussianBlur(np.log(np.maximum(filled, np.float32(0.1))), None, 1.5)
    slopes = [cv2.Sobel(logarithm, cv2.CV_32F, dx, 1 - dx)[rows, columns] for dx in (1, 0)]
    return np.stack(slopes, axis=1).astype(np.float64)
