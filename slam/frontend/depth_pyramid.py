"""Depth pyramid: a depth image as oriented points on coarse pixel grids, which is what ICP works on."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import cv2
import numpy as np

from razer.arrays import BoolArray, Float32Array, Uint16Array
from razer.frame import Intrinsics

FINE_WIDTH = 160  # pixels across of the finest grid: registration is no better on finer ones, only slower
N_LEVELS = 2  # the coarse one draws from afar, the fine one decides; a third changes nothing but the time
MIN_DEPTH_M = 0.1  # nearer points, and those behind a camera, are not projected into it
JUMP_SHARE = 0.05  # neighbours whose depths differ by more than this share (and 3 cm) lie on two surfaces
JUMP_M = 0.03
NOWHERE_M = 1e6  # stands for a pixel without a reading, which is farther than any
QUICKLY = (cv2.IMWRITE_PNG_COMPRESSION, 1)  # a millisecond; twice that saves a sixtieth more
MAX_STEPS, MIN_RANGE_M = 65_535, 1e-3  # of depth as it is kept; an image without readings has a range, too


@dataclass(frozen=True)
class SurfaceGrid:
    """Oriented points on the pixel grid of `intrinsics`, in camera coordinates.

    points and normals (3, H * W) float32 metres, normals of length one towards the camera; valid (H * W,) bool;
    sample_points and sample_normals (3, R), those of every other valid one: all of them lead to the same motion.
    """

    intrinsics: Intrinsics
    points: Float32Array
    normals: Float32Array
    valid: BoolArray
    sample_points: Float32Array
    sample_normals: Float32Array


def fine_depth(depth: Float32Array, intrinsics: Intrinsics, max_depth_m: float) -> tuple[Float32Array, Intrinsics]:
    """The depth image (H, W) reduced to about FINE_WIDTH pixels across, without outliers and readings farther than
    max_depth_m, whose noise drowns what shape there is."""
    smooth = _without_outliers(depth)
    near = np.where(smooth <= max_depth_m, smooth, np.float32(0))
    for _ in range(max(0, round(np.log2(intrinsics.width / FINE_WIDTH)))):
        near, intrinsics = halved(near, intrinsics)
    return near, intrinsics


def _without_outliers(depth: Float32Array) -> Float32Array:
    """The median (H, W) of the readings round each pixel; none where most of them failed.

    Holes are no readings: taken for the nearest there are, they drew walls seen at a grazing angle, where many readings
    fail, by a centimetre towards the camera. Such walls taper wherever the camera is, as if it had not moved.
    """
    below = cv2.medianBlur(np.ascontiguousarray(depth), 3)
    above = cv2.medianBlur(_far_holes(depth), 3)
    one_surface = above - below < JUMP_M + JUMP_SHARE * below
    return np.where(one_surface, (below + above) / 2, below)


class DepthPyramid:
    """Grids of oriented points of a reduced depth image (H, W), made when they are first asked for. The image is kept
    in 65,535 steps of equal size up to its farthest reading: 0.06 mm for 4 m, a twentieth of a sensor's noise; between
    two uses as a PNG, in two thirds of the memory."""

    def __init__(self, depth: Float32Array, intrinsics: Intrinsics) -> None:
        self._step_m = max(float(depth.max(initial=0.0)), MIN_RANGE_M) / MAX_STEPS
        self._steps: Uint16Array | None = np.rint(depth / np.float32(self._step_m)).astype(np.uint16)
        self._png = np.zeros(0, np.uint8)
        self.intrinsics = intrinsics
        self._levels: tuple[SurfaceGrid, ...] | None = None

    def __getstate__(self) -> dict[str, Any]:
        return {**vars(self), "_levels": None}

    @property
    def depth(self) -> Float32Array:
        """The depth image (H, W) that the grids are made of, metres."""
        if self._steps is not None:
            return self._steps * np.float32(self._step_m)
        steps = cv2.imdecode(self._png, cv2.IMREAD_UNCHANGED)
        assert steps is not None
        return steps.astype(np.float32) * np.float32(self._step_m)

    @property
    def n_bytes(self) -> int:
        """The size of the depth image as it is kept now."""
        return self._png.nbytes if self._steps is None else self._steps.nbytes

    def without(self, pixels: BoolArray) -> DepthPyramid:
        """The same without the readings of some pixels (H, W)."""
        return DepthPyramid(np.where(pixels, np.float32(0), self.depth), self.intrinsics)

    @property
    def levels(self) -> tuple[SurfaceGrid, ...]:
        """The grids, the coarsest first."""
        if self._levels is None:
            depth, intrinsics = self.depth, self.intrinsics
            grids = [surface_grid(depth, intrinsics)]
            for _ in range(N_LEVELS - 1):
                depth, intrinsics = halved(depth, intrinsics)
                grids.append(surface_grid(depth, intrinsics))
            self._levels = tuple(reversed(grids))
        return self._levels

    @property
    def n_points(self) -> int:
        """Oriented points of the finest grid."""
        return int(self.levels[-1].valid.sum())

    def release(self) -> None:
        """Free the grids, and pack the depth image; they are made again, the same, when they are asked for."""
        self._levels = None
        if self._steps is not None:
            self._png, self._steps = cv2.imencode(".png", self._steps, QUICKLY)[1], None


def halved(depth: Float32Array, intrinsics: Intrinsics) -> tuple[Float32Array, Intrinsics]:
    """Half the pixels each way: the mean of those of four readings that lie on the nearest of their surfaces."""
    rows, columns = depth.shape[0] // 2, depth.shape[1] // 2
    # Four whole images, since what lies next to each other in memory is quicker to go through.
    far = _far_holes(depth)
    corners = [np.ascontiguousarray(far[i : 2 * rows : 2, j : 2 * columns : 2]) for i in (0, 1) for j in (0, 1)]
    nearest = np.minimum(np.minimum(corners[0], corners[1]), np.minimum(corners[2], corners[3]))
    limit = np.minimum(nearest * np.float32(1 + JUMP_SHARE) + np.float32(JUMP_M), np.float32(NOWHERE_M))
    total, count = np.zeros((rows, columns), np.float32), np.zeros((rows, columns), np.float32)
    for corner in corners:
        same = corner < limit
        total += corner * same
        count += same
    half = Intrinsics(
        columns,
        rows,
        intrinsics.fx / 2,
        intrinsics.fy / 2,
        (intrinsics.cx + 0.5) / 2 - 0.5,
        (intrinsics.cy + 0.5) / 2 - 0.5,
    )
    return (total / np.maximum(count, 1)).astype(np.float32), half


def _far_holes(depth: Float32Array) -> Float32Array:
    return np.where(depth > 0, depth, np.float32(NOWHERE_M))


def surface_grid(depth: Float32Array, intrinsics: Intrinsics) -> SurfaceGrid:
    """Points of a depth image (H, W) and their normals by central differences; a point at a jump has none."""
    columns = (np.arange(intrinsics.width, dtype=np.float32) - np.float32(intrinsics.cx)) / np.float32(intrinsics.fx)
    rows = (np.arange(intrinsics.height, dtype=np.float32) - np.float32(intrinsics.cy)) / np.float32(intrinsics.fy)
    points = np.stack([columns * depth, rows[:, None] * depth, depth])
    right, down = np.zeros_like(points), np.zeros_like(points)
    right[:, :, 1:-1] = points[:, :, 2:] - points[:, :, :-2]
    down[:, 1:-1] = points[:, 2:] - points[:, :-2]
    normals = np.stack(
        [
            down[1] * right[2] - down[2] * right[1],
            down[2] * right[0] - down[0] * right[2],
            down[0] * right[1] - down[1] * right[0],
        ]
    )
    length = np.sqrt((normals**2).sum(axis=0))
    valid = _smooth(depth) & (length > 0)
    normals /= np.maximum(length, np.float32(1e-12))
    points, normals, flat = points.reshape(3, -1), normals.reshape(3, -1), valid.ravel()
    sample = np.flatnonzero(flat)[::2]
    return SurfaceGrid(
        intrinsics, points, normals, flat, np.take(points, sample, axis=1), np.take(normals, sample, axis=1)
    )


def _smooth(depth: Float32Array) -> BoolArray:
    """Which pixels have readings on both sides, each way, on the same surface."""
    smooth = np.zeros(depth.shape, bool)
    center = depth[1:-1, 1:-1]
    limit = JUMP_M + JUMP_SHARE * center
    left, right, up, down = depth[1:-1, :-2], depth[1:-1, 2:], depth[:-2, 1:-1], depth[2:, 1:-1]
    sides = (center > 0) & (left > 0) & (right > 0) & (up > 0) & (down > 0)
    smooth[1:-1, 1:-1] = sides & (np.abs(right - left) < limit) & (np.abs(down - up) < limit)
    return smooth
