"""Weights of frames in the map: what a frame shows counts less where its pose, among those of its neighbours, is
uncertain by a voxel or more."""

from __future__ import annotations

from bisect import bisect_right
from collections.abc import Iterable

import numpy as np

from slam.report import GraphReport

MIN_WEIGHT = 0.25  # what is seen from uncertain poses alone must be mapped all the same


def frame_weights(graph: GraphReport, indices: Iterable[int], voxel_size_m: float) -> dict[int, float]:
    """Weights below 1 by index of frame; of the others there is none.

    A reading that is off by s voxels beside its own error, of about one, counts 1 / (1 + s^2), as a power of two.

    Args:
        graph: the finished pose graph.
        indices: the frames that the map is made of.
        voxel_size_m: edge of a voxel, metres.
    """
    sigmas_m = graph.local_sigmas_m
    keyframes = sorted(sigmas_m)
    weights: dict[int, float] = {}
    for index in indices:
        before = bisect_right(keyframes, index) - 1  # the keyframe that tracking started from
        if before >= 0 and (weight := _weight(sigmas_m[keyframes[before]] / voxel_size_m)) < 1:
            weights[index] = weight
    return weights


def _weight(sigma_voxels: float) -> float:
    return float(np.clip(2.0 ** np.rint(-np.log2(1 + sigma_voxels**2)), MIN_WEIGHT, 1.0))
