"""SIFT features, which match where ORB's do not: from another side, closer, or in another light (Lowe, IJCV 2004;
compared as RootSIFT: Arandjelovic and Zisserman, CVPR 2012). Descriptors are kept as the square roots of
their entries in 16 steps, two to a byte: they match as well, in half of the memory."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import cv2
import numpy as np

from razer.arrays import BoolArray, Float32Array, FloatArray, IndexArray, Uint8Array
from razer.frame import Frame
from slam.config import FeatureSettings, SlamConfig
from slam.frontend.color_calibration import ColorCalibration
from slam.frontend.features import Features, Readout, depth_at, no_features, raster_ranks

WIDTH = 320  # pixels across of the image that is looked at: larger ones take four times as long and match no better
CONTRAST = 0.004  # of grey levels in [0, 1]; low, as walls have little, and the raster keeps the strongest anyway
# Few are enough of views that share much, and faint ones find what shares a fifth: of pairs of a kitchen that share
# less than 30 % a quarter is found by 460 features, half by 910, of a scan of it 72 and 90 of 100.
RASTER = FeatureSettings(count=1000)
# The strongest of each part, evenly spread: a motion by them is more exact, and its uncertainty truer, than by as many
# with more in some parts, or by all (twin rooms in no order: 0.5, 0.7, 1.0 cm, NEES 9, 14, 24).
PROMINENT = FeatureSettings(count=500)
USUAL_SIZE_PIXELS = 4.0  # of the smallest features
SAME_COSINE = 1 - 1e-6  # above it single precision tells nothing apart
MAX_LEVEL = 15  # the root of the largest entry of a byte, 255, as its four bits have it
MAX_RATIO = 0.9  # the best match must be nearer than this share of the second's distance (Lowe), and mutual


class WideFeatures:
    """The features of a frame, extracted when they are first asked for; until then the frame is kept."""

    def __init__(self, frame: Frame, calibration: ColorCalibration, config: SlamConfig) -> None:
        self._frame: Frame | None = frame
        self._calibration, self._config = calibration, config
        self._features, self._n_prominent = no_features(np.zeros((0, 64), np.uint8)), 0

    @classmethod
    def known(cls, features: Features, n_prominent: int | None = None) -> WideFeatures:
        """Those that were extracted before, of which so many come first that are prominent; None = all."""
        result = cls.__new__(cls)
        result._frame, result._features = None, features
        result._n_prominent = len(features) if n_prominent is None else n_prominent
        return result

    def __getstate__(self) -> dict[str, Any]:
        self.extract()
        return {"_frame": None, "_features": self._features, "_n_prominent": self._n_prominent}

    def extract(self) -> None:
        """Extract them now, and let the frame go."""
        if self._frame is not None:
            self._features, self._n_prominent = _extracted(self._frame, self._calibration, self._config)
            self._frame = None

    @property
    def features(self) -> Features:
        """Features with descriptors (N, 64), which `levels` unpacks; prominent ones come first."""
        self.extract()
        return self._features

    @property
    def n_prominent(self) -> int:
        """How many of the features are the strongest of their part of the image."""
        self.extract()
        return self._n_prominent

    @property
    def prominent(self) -> Features:
        """These."""
        return self.features.select(slice(self.n_prominent))

    def select(self, which: BoolArray) -> WideFeatures:
        """Those of them that a mask (N,) has."""
        features = self.features.select(which)
        return WideFeatures.known(features, int(which[: self.n_prominent].sum()))


def _extracted(frame: Frame, calibration: ColorCalibration, config: SlamConfig) -> tuple[Features, int]:
    """The features of a frame, and how many of them are prominent."""
    k = frame.intrinsics
    step = max(1, round(k.width / WIDTH))
    points, descriptors, n_prominent = _described(cv2.cvtColor(frame.rgb, cv2.COLOR_RGB2GRAY), step)
    if len(points) == 0:
        return no_features(descriptors), 0
    pixels = (np.array([point.pt for point in points]) + 0.5) * step - 0.5
    rays = (pixels - (k.cx, k.cy)) / (k.fx, k.fy)
    sigma = config.features.pixel_sigma / k.fx * step * np.array([max(1, p.size / USUAL_SIZE_PIXELS) for p in points])
    depth_m, readout = depth_at(frame, calibration, rays), Readout.of(k, config.color)
    return Features.of(rays, descriptors, depth_m, sigma, readout), n_prominent


def _described(gray: Uint8Array, step: int) -> tuple[Sequence[cv2.KeyPoint], Uint8Array, int]:
    """Features of an image reduced by a whole number, spread over it, first the strongest of each cell of the raster,
    then the second of each, and so on; their descriptors (N, 64); and how many are prominent."""
    rows, columns = (length // step * step for length in gray.shape)
    small = cv2.resize(gray[:rows, :columns], (columns // step, rows // step), interpolation=cv2.INTER_AREA)
    # All are described, and then chosen from: to find and to describe them one after the other takes as long.
    points, descriptors = cv2.SIFT.create(contrastThreshold=CONTRAST).detectAndCompute(small, None)
    if descriptors is None:
        return [], np.zeros((0, 64), np.uint8), 0
    rank = raster_ranks(points, small.shape, RASTER)[1]
    order = np.lexsort((-np.array([point.response for point in points]), rank))
    chosen = order[rank[order] < RASTER.per_cell]
    n_prominent = int((rank < PROMINENT.per_cell).sum())
    return [points[n] for n in chosen], packed(descriptors[chosen]), n_prominent


def packed(descriptors: FloatArray) -> Uint8Array:
    """The roots of descriptors (N, 128) of entries in [0, 255], in 16 steps (N, 64): an even entry in the low four bits
    of a byte, the odd one after it in the high ones."""
    roots = np.rint(np.sqrt(descriptors.clip(0, 255))).clip(0, MAX_LEVEL).astype(np.uint8)
    return roots[:, ::2] | roots[:, 1::2] << 4


def levels(descriptors: Uint8Array) -> Uint8Array:
    """Roots of entries (N, 128), 0 to 15, of packed descriptors (N, 64)."""
    return np.stack([descriptors & MAX_LEVEL, descriptors >> 4], axis=2).reshape(
        len(descriptors), 2 * descriptors.shape[1]
    )


RootPair = tuple[Float32Array, Float32Array]  # of a target's and a source's features, see `root_sift`


def match_wide_features(target: Features, source: Features, roots: RootPair | None = None) -> IndexArray:
    """Pairs (M, 2) of (target, source) features that are each other's nearest by far, of which the target has a
    depth; roots: what `root_sift` makes of the descriptors of both, where it is known."""
    with_depth = np.flatnonzero(target.depth_m > 0)
    if len(with_depth) < 2 or len(source) < 2:
        return np.zeros((0, 2), np.intp)
    of_target, of_source = roots or (root_sift(target.descriptors), root_sift(source.descriptors))
    cosine = of_source @ of_target[with_depth].T
    rows, nearest = np.arange(len(source)), cosine.argmax(axis=1)
    best = cosine[rows, nearest]
    mutual = best == cosine.max(axis=0)[nearest]
    cosine[rows, nearest] = -1.0
    best, second = (np.minimum(each, SAME_COSINE) for each in (best, cosine.max(axis=1)))
    kept = np.flatnonzero(mutual & (1 - best < MAX_RATIO**2 * (1 - second)))
    return np.column_stack([with_depth[nearest[kept]], kept])


def root_sift(descriptors: Uint8Array) -> Float32Array:
    """Descriptors (N, 128) of length one of packed ones (N, 64)."""
    root = levels(descriptors).astype(np.float32)
    result: Float32Array = root / np.maximum(np.linalg.norm(root, axis=1, keepdims=True), np.float32(1e-6))
    return result
