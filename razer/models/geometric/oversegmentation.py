"""Oversegmentation: connected components that no edge crosses, grown to the nearest pixels."""

from __future__ import annotations

import cv2
import numpy as np

from razer.arrays import BoolArray, Float32Array, Int32Array, Uint8Array

_MIN_SEED = 20  # pixels of the smallest edge-free region
_MIN_CORE = 80  # pixels of the smallest part between necks that is a region of its own
_GROWTH, _GROWTH_OVER_HOLES = 6.0, 2.5  # pixels regions grow over edges, and where there is no depth


def oversegment(strength: Float32Array, valid: BoolArray) -> tuple[Int32Array, int]:
    """Label image (h, w), 0 .. n-1 and -1 = unlabelled, of the regions where strength (h, w) stays below 1, and n.

    Large parts of a region that only a neck one pixel wide joins are regions of their own, as the neck may be a
    gap in an edge. Then all grow over the edges to the nearest pixels."""
    inside = ((strength < 1) & valid).astype(np.uint8)
    cores, n_cores = _components(cv2.erode(inside, np.ones((2, 2), np.uint8)), _MIN_CORE)
    whole, n_whole = _components(inside, _MIN_SEED)
    region_of_core = np.zeros(n_cores + 1, np.int64)  # the region each core is part of
    in_core = np.flatnonzero(cores)
    region_of_core[cores.ravel()[in_core]] = whole.ravel()[in_core]
    n_within = np.bincount(region_of_core[1:], minlength=n_whole + 1)
    number = np.zeros(n_whole + 1, np.int32)  # of a region that stays whole
    number[region_of_core[1:]] = np.arange(1, n_cores + 1)
    number[n_within > 1] = 0
    without_core = np.flatnonzero(n_within[1:] == 0) + 1
    number[without_core] = n_cores + np.arange(1, len(without_core) + 1)
    number[0] = 0
    labels = np.maximum(cores, number[whole])
    return _grown(labels, valid) - 1, n_cores + len(without_core)


def _components(inside: Uint8Array, min_pixels: int) -> tuple[Int32Array, int]:
    """Connected components of at least min_pixels, numbered from 1, and how many."""
    _, labels, stats, _ = cv2.connectedComponentsWithStats(inside, connectivity=4)
    large = stats[:, cv2.CC_STAT_AREA] >= min_pixels
    large[0] = False
    return np.where(large, np.cumsum(large), 0).astype(np.int32)[labels], int(large.sum())


def _grown(labels: Int32Array, valid: BoolArray) -> Int32Array:
    """The labels (0 = unlabelled), each pixel near one taking that of the nearest."""
    distance, nearest = cv2.distanceTransformWithLabels(
        (labels == 0).astype(np.uint8), cv2.DIST_L2, 3, labelType=cv2.DIST_LABEL_PIXEL
    )
    label_of = np.zeros(nearest.max() + 1, np.int32)
    labelled = np.flatnonzero(labels)
    label_of[nearest.ravel()[labelled]] = labels.ravel()[labelled]
    reached = distance < np.where(valid, np.float32(_GROWTH), np.float32(_GROWTH_OVER_HOLES))
    return np.where(reached, label_of[nearest], 0)
