"""ORB features spread over the image, with the depth they lie at, and their matches (Rublee et al., ICCV 2011)."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import cv2
import numpy as np

from razer.arrays import Float64Array, IndexArray, Uint8Array
from razer.frame import Frame
from slam.frontend.color_calibration import ColorCamera

N_FEATURES = 1000
CELLS = (6, 8)  # rows and columns of the raster over which features are spread
OCTAVE = 1.2
MAX_DISTANCE = 64  # bits of 256: farther descriptors are not of the same point
RATIO = 0.85  # the best match has to be this much nearer than the second
FEW = 300  # with fewer corners than this, faint ones are looked for, too
FAINT_BLUR, FAINT_SHADE, FAINT_GAIN = 2.0, 8, 8.0  # pixels of grain and of shading between which they lie; contrast


@dataclass(frozen=True)
class Features:
    """N corners of a colour image: rays (N, 2) float64, nominal x / z and y / z of the depth camera; descriptors
    (N, 32) uint8; depth_m (N,) float64 along the depth camera's axis, 0 = none; sigma (N,) of the rays; lateness (N,),
    when each was read, -0.5 = with the image's first row, 0.5 = with its last."""

    rays: Float64Array
    descriptors: Uint8Array
    depth_m: Float64Array
    sigma: Float64Array
    lateness: Float64Array

    def __len__(self) -> int:
        return len(self.rays)


class FeatureExtractor:
    """Finds features; holds OpenCV's detector, which is costly to make."""

    def __init__(self, pixel_sigma: float = 1.5) -> None:
        self._detector = cv2.ORB.create(nfeatures=3 * N_FEATURES, fastThreshold=8, scaleFactor=OCTAVE)
        self._pixel_sigma = pixel_sigma

    def find(self, frame: Frame, camera: ColorCamera) -> Features:
        """The features of a frame, with depths where its colour camera, as far as known, saw them."""
        gray = cv2.cvtColor(frame.rgb, cv2.COLOR_RGB2GRAY)
        corners, descriptors = self._described(gray)
        if len(corners) < FEW:
            faint, of_faint = self._described(faint_texture(gray))
            corners, descriptors = [*corners, *faint], np.concatenate([descriptors, of_faint])
        if len(corners) == 0:
            return Features(np.zeros((0, 2)), descriptors, np.zeros(0), np.zeros(0), np.zeros(0))
        octaves = np.array([corner.octave for corner in corners]) & 255
        pixels = in_image(np.array([corner.pt for corner in corners], np.float64), octaves, gray.shape)
        k = frame.intrinsics
        rays = (pixels - (k.cx, k.cy)) / (k.fx, k.fy)
        sigma = (self._pixel_sigma / k.fx * OCTAVE**octaves).astype(np.float64)
        lateness = (pixels[:, 1] + 0.5) / k.height - 0.5
        return Features(rays, descriptors, depth_at(frame, camera, rays), sigma, lateness)

    def _described(self, gray: Uint8Array) -> tuple[Sequence[cv2.KeyPoint], Uint8Array]:
        """Corners spread over the image, and their descriptors (N, 32)."""
        found = spread(self._detector.detect(gray), gray.shape)
        corners, descriptors = self._detector.compute(gray, found)
        if descriptors is None:
            return [], np.zeros((0, 32), np.uint8)
        return corners, descriptors.astype(np.uint8, copy=False)


def faint_texture(gray: Uint8Array) -> Uint8Array:
    """An image (H, W) without grain and shading, and what is left made strong: painted walls have corners, too."""
    smooth = cv2.GaussianBlur(gray.astype(np.float32), (0, 0), FAINT_BLUR)
    small = cv2.resize(smooth, None, fx=1 / FAINT_SHADE, fy=1 / FAINT_SHADE, interpolation=cv2.INTER_AREA)
    shade = cv2.resize(cv2.blur(small, (3, 3)), gray.shape[::-1])
    return np.clip(128 + FAINT_GAIN * (smooth - shade), 0, 255).astype(np.uint8)


def in_image(points: Float64Array, octaves: IndexArray, shape: tuple[int, ...]) -> Float64Array:
    """Where in the image (H, W) corners (N, 2) lie that OpenCV reports as a pixel of its pyramid times
    the nominal reduction: off by half a pixel of the reduced image, and by what its size was rounded."""
    nominal = OCTAVE ** octaves[:, None]
    size = np.array(shape[::-1], np.float64)
    result: Float64Array = (points / nominal + 0.5) * (size / np.rint(size / nominal)) - 0.5
    return result


def spread(corners: Sequence[cv2.KeyPoint], shape: tuple[int, ...]) -> list[cv2.KeyPoint]:
    """The strongest corners of each cell of a raster, so that a poster does not take them all."""
    if not corners:
        return []
    pixels = np.array([corner.pt for corner in corners])
    row, column = (pixels[:, ::-1] * CELLS / np.array(shape)).astype(int).T
    cell = row * CELLS[1] + column
    order = np.lexsort((-np.array([corner.response for corner in corners]), cell))
    start = np.searchsorted(cell[order], cell[order])
    rank = np.arange(len(order)) - start
    return [corners[i] for i in order[rank < N_FEATURES // (CELLS[0] * CELLS[1])]]


def depth_at(frame: Frame, camera: ColorCamera, rays: Float64Array) -> Float64Array:
    """Depth (N,) in metres along the frame's axis of what the colour camera saw along nominal rays; 0 = none."""
    k = frame.intrinsics
    depth = np.full(len(rays), 2.0)
    for _ in range(2):  # with a baseline, where to read depends on what is read
        u, v = (camera.depth_rays(rays, depth) * (k.fx, k.fy) + (k.cx, k.cy)).T
        column, row = np.rint(u).astype(int), np.rint(v).astype(int)
        inside = (column >= 0) & (column < k.width) & (row >= 0) & (row < k.height)
        read = np.where(inside, frame.depth[row.clip(0, k.height - 1), column.clip(0, k.width - 1)], 0.0)
        depth = np.where(read > 0, read, depth)
    return read.astype(np.float64)


_MATCHER = cv2.BFMatcher(cv2.NORM_HAMMING)


def matches(target: Features, source: Features) -> IndexArray:
    """Pairs (M, 2) of (target, source) features that look alike, of which the target has a depth."""
    known = np.flatnonzero(target.depth_m > 0)
    if len(known) < 2 or len(source) < 2:
        return np.zeros((0, 2), np.intp)
    found = _MATCHER.knnMatch(source.descriptors, target.descriptors[known], k=2)
    pairs = [
        (known[best.trainIdx], best.queryIdx)
        for best, second in found
        if best.distance < MAX_DISTANCE and best.distance < RATIO * second.distance
    ]
    return np.array(pairs, np.intp).reshape(-1, 2)
