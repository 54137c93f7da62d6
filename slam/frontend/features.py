"""ORB features spread over the image, with the depth they lie at, and their matches (Rublee et al., ICCV 2011; ratio
test: Lowe, IJCV 2004)."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

import cv2
import numpy as np

from razer.arrays import BoolArray, Float32Array, Float64Array, FloatArray, IndexArray, Uint8Array
from razer.errors import UnusableFrame
from razer.frame import Frame, Intrinsics
from slam.config import ColorSettings, FeatureSettings, SlamConfig
from slam.frontend.color_calibration import ColorCalibration

OCTAVE = 1.2  # reduction from one level of ORB's image pyramid to the next, as its authors chose
FAST_THRESHOLD = 8  # of grey levels; low, since the raster keeps the strongest corners of each cell anyway
DETECTED_PER_KEPT = 3  # corners detected for each one kept, so that cells with weak ones get their share
FEW = 300  # with fewer corners than this, faint ones are looked for, too
MIN_SIDE = 4  # pixels; nothing can be told from fewer
FAINT_BLUR, FAINT_SHADE, FAINT_GAIN = 2.0, 8, 8.0  # pixels of grain and of shading between which they lie; contrast


class Readout(NamedTuple):
    """When the rows of an image are read, -0.5 = the first, 0.5 = the last: that of nominal y / z = 0, and how much
    later those are that look further down."""

    on_axis: float
    per_bearing: float

    @classmethod
    def of(cls, k: Intrinsics, settings: ColorSettings) -> Readout:
        """That of a camera."""
        return cls((k.cy + 0.5) / k.height - 0.5, k.fy / k.height) if settings.rolling_shutter else ALL_AT_ONCE


ALL_AT_ONCE = Readout(0.0, 0.0)


@dataclass(frozen=True)
class Features:
    """N corners of a colour image: rays (N, 2), nominal x / z and y / z of the depth camera; descriptors (N, 32) uint8;
    depth_m (N,) along the depth camera's axis, 0 = none; sigma (N,) of the rays; and when rows were read. Kept as
    float32, which tells a ten-thousandth of a pixel."""

    rays: Float32Array
    descriptors: Uint8Array
    depth_m: Float32Array
    sigma: Float32Array
    readout: Readout = ALL_AT_ONCE

    @classmethod
    def of(
        cls, rays: FloatArray, descriptors: Uint8Array, depth_m: FloatArray, sigma: FloatArray, readout: Readout
    ) -> Features:
        """Features of numbers of any precision."""
        rays, depth_m, sigma = (each.astype(np.float32) for each in (rays, depth_m, sigma))
        return cls(rays, descriptors, depth_m, sigma, readout)

    def __len__(self) -> int:
        return len(self.rays)

    @property
    def row_times(self) -> Float64Array:
        """When each (N,) was read."""
        return self.readout.on_axis + self.readout.per_bearing * self.rays[:, 1].astype(np.float64)

    def select(self, which: BoolArray | IndexArray | slice) -> Features:
        """Those of them that a mask (N,), numbers or a range have."""
        return Features(self.rays[which], self.descriptors[which], self.depth_m[which], self.sigma[which], self.readout)


class FeatureExtractor:
    """Extracts features; holds OpenCV's detector, which is costly to make. Without a rolling shutter all rows of an
    image are of one moment."""

    def __init__(self, config: SlamConfig) -> None:
        self._settings = config.features
        self._color = config.color
        self._detector = cv2.ORB.create(
            nfeatures=DETECTED_PER_KEPT * self._settings.count, fastThreshold=FAST_THRESHOLD, scaleFactor=OCTAVE
        )

    def extract(self, frame: Frame, calibration: ColorCalibration) -> Features:
        """The features of a frame, with depths where its colour camera, as far as known, saw them; raises UnusableFrame
        for images of a few pixels."""
        if min(frame.depth.shape) < MIN_SIDE:
            raise UnusableFrame(f"an image of {frame.intrinsics.width}x{frame.intrinsics.height} pixels shows nothing")
        gray = cv2.cvtColor(frame.rgb, cv2.COLOR_RGB2GRAY)
        corners, descriptors = self._described(gray)
        if len(corners) < FEW and min(gray.shape) >= FAINT_SHADE:
            faint, of_faint = self._described(faint_texture(gray))
            corners, descriptors = [*corners, *faint], np.concatenate([descriptors, of_faint])
        if len(corners) == 0:
            return no_features(descriptors)
        octaves = np.array([corner.octave for corner in corners]) & 255
        pixels = in_image(np.asarray(cv2.KeyPoint.convert(corners), np.float64), octaves, gray.shape)
        k = frame.intrinsics
        rays = (pixels - (k.cx, k.cy)) / (k.fx, k.fy)
        sigma = (self._settings.pixel_sigma / k.fx * OCTAVE**octaves).astype(np.float64)
        depth_m = depth_at(frame, calibration, rays)
        return Features.of(rays, descriptors, depth_m, sigma, Readout.of(k, self._color))

    def _described(self, gray: Uint8Array) -> tuple[Sequence[cv2.KeyPoint], Uint8Array]:
        """Corners spread over the image, and their descriptors (N, 32)."""
        strongest = spread(self._detector.detect(gray), gray.shape, self._settings)
        corners, descriptors = self._detector.compute(gray, strongest)
        if descriptors is None:
            return [], np.zeros((0, 32), np.uint8)
        return corners, descriptors.astype(np.uint8, copy=False)


def no_features(descriptors: Uint8Array) -> Features:
    """Features of an image without corners; descriptors (0, B) say of which kind."""
    return Features.of(np.zeros((0, 2)), descriptors, np.zeros(0), np.zeros(0), ALL_AT_ONCE)


def faint_texture(gray: Uint8Array) -> Uint8Array:
    """An image (H, W) without grain and shading, and what is left made strong: painted walls have corners, too."""
    smooth = cv2.GaussianBlur(gray.astype(np.float32), (0, 0), FAINT_BLUR)
    small = cv2.resize(smooth, None, fx=1 / FAINT_SHADE, fy=1 / FAINT_SHADE, interpolation=cv2.INTER_AREA)
    shade = cv2.resize(cv2.blur(small, (3, 3)), gray.shape[::-1])
    return np.clip(128 + FAINT_GAIN * (smooth - shade), 0, 255).astype(np.uint8)


def in_image(points: Float64Array, octaves: IndexArray, shape: tuple[int, ...]) -> Float64Array:
    """Where in the image (H, W) corners (N, 2) lie that OpenCV reports as a pixel of its pyramid times
    the nominal reduction: wrong by half a pixel of the reduced image, and by what its size was rounded."""
    nominal = OCTAVE ** octaves[:, None]
    size = np.array(shape[::-1], np.float64)
    result: Float64Array = (points / nominal + 0.5) * (size / np.rint(size / nominal)) - 0.5
    return result


def spread(corners: Sequence[cv2.KeyPoint], shape: tuple[int, ...], settings: FeatureSettings) -> list[cv2.KeyPoint]:
    """The strongest corners of each cell of a raster, so that a poster does not take them all, cell by cell."""
    if not corners:
        return []
    cell, rank = raster_ranks(corners, shape, settings)
    order = np.lexsort((rank, cell))
    return [corners[i] for i in order[rank[order] < settings.per_cell].tolist()]


def raster_ranks(
    corners: Sequence[cv2.KeyPoint], shape: tuple[int, ...], settings: FeatureSettings
) -> tuple[IndexArray, IndexArray]:
    """In which cell (N,) of a raster corners lie, and how many stronger ones (N,) lie there."""
    rows, columns = settings.grid_rows, settings.grid_columns
    pixels = np.asarray(cv2.KeyPoint.convert(corners), np.float64)
    row, column = (pixels[:, ::-1] * (rows, columns) / np.array(shape)).astype(int).T
    cell = row * columns + column
    order = np.lexsort((-np.array([corner.response for corner in corners]), cell))
    rank = np.empty_like(order)
    rank[order] = np.arange(len(order)) - np.searchsorted(cell[order], cell[order])
    return cell, rank


def depth_at(frame: Frame, calibration: ColorCalibration, rays: Float64Array) -> Float64Array:
    """Depth (N,) in metres along the frame's axis of what the colour camera saw along nominal rays; 0 = none."""
    return depth_along(frame.depth, frame.intrinsics, calibration, rays)


def depth_along(
    depth_image: Float32Array, intrinsics: Intrinsics, calibration: ColorCalibration, rays: Float64Array
) -> Float64Array:
    """The same (N,) from a depth image (H, W) of any size with its intrinsics."""
    k, depth = intrinsics, np.full(len(rays), 2.0)
    for _ in range(2):  # with a baseline, where to read depends on what is read
        u, v = (calibration.depth_rays(rays, depth) * (k.fx, k.fy) + (k.cx, k.cy)).T
        column, row = np.rint(u).astype(int), np.rint(v).astype(int)
        inside = (column >= 0) & (column < k.width) & (row >= 0) & (row < k.height)
        read = np.where(inside, depth_image[row.clip(0, k.height - 1), column.clip(0, k.width - 1)], 0.0)
        depth = np.where(read > 0, read, depth)
    return read.astype(np.float64)


_MATCHER = cv2.BFMatcher(cv2.NORM_HAMMING)


def match_features(target: Features, source: Features, settings: FeatureSettings) -> IndexArray:
    """Pairs (M, 2) of (target, source) features with similar descriptors, of which the target has a depth."""
    with_depth = np.flatnonzero(target.depth_m > 0)
    if len(with_depth) < 2 or len(source) < 2:
        return np.zeros((0, 2), np.intp)
    nearest_two = _MATCHER.knnMatch(source.descriptors, target.descriptors[with_depth], k=2)
    pairs = [
        (with_depth[best.trainIdx], best.queryIdx)
        for best, second in nearest_two
        if best.distance < settings.max_distance_bits and best.distance < settings.max_ratio * second.distance
    ]
    return np.array(pairs, np.intp).reshape(-1, 2)
