"""Rigid matches: features that lie as far from each other in one view as in the other, whatever moved between the two
(pairwise consistency, as in Leordeanu and Hebert, ICCV 2005), and the motion they say by absolute orientation (Horn,
1987).

Far cheaper than a registration, and a start for one where too few agree for PnP: views 50 degrees or a metre apart.
"""

from __future__ import annotations

import numpy as np

from razer.arrays import BoolArray, Float64Array, IndexArray
from slam.frontend.features import Features
from slam.frontend.wide_features import match_wide_features

# Matched features whose distance is the same in both views but for so much, some of it for each metre of depth, may
# belong to one scene.
SAME_DISTANCE_M, SAME_DISTANCE_SHARE = 0.02, 0.02
MOST = 0.6  # share of a set that each of it must agree with: matches that are false agree with few
ROUNDS = 3  # of leaving out those that do not


class RigidMatches:
    """The largest set of matched features of two views that agree with one of them."""

    def __init__(self, target: Features, source: Features) -> None:
        t, s = match_wide_features(target, source).T
        t, s = (numbers[source.depth_m[s] > 0] for numbers in (t, s))
        there, here = _points(target, t), _points(source, s)
        depth_m = np.maximum(target.depth_m[t], source.depth_m[s])
        margin_m = SAME_DISTANCE_M + SAME_DISTANCE_SHARE * np.maximum(depth_m, depth_m[:, None])
        agree: BoolArray = np.abs(_distances(there) - _distances(here)) < margin_m
        best = agree[int(agree.sum(axis=1).argmax())] if len(t) else np.zeros(0, bool)
        self._kept = _consistent(np.flatnonzero(best), agree)
        self._there, self._here = there, here
        self.n_agreeing = int(best.sum())  # of views that share nothing hardly any have a dozen

    def motion(self) -> Float64Array:
        """target_from_source (4, 4) as those have it that agree with most others; of three features at least."""
        return absolute_orientations(self._here[None, self._kept], self._there[None, self._kept])[0]


def _consistent(numbers: IndexArray, agree: BoolArray) -> IndexArray:
    for _ in range(ROUNDS):
        fewer = numbers[agree[np.ix_(numbers, numbers)].mean(axis=1) >= MOST] if len(numbers) else numbers
        if len(fewer) < 3:
            break
        numbers = fewer
    return numbers


def _points(features: Features, numbers: IndexArray) -> Float64Array:
    rays = np.column_stack([features.rays[numbers], np.ones(len(numbers))])
    return rays.astype(np.float64) * features.depth_m[numbers, None]


def _distances(points: Float64Array) -> Float64Array:
    """Between points (M, M), metres."""
    result: Float64Array = np.linalg.norm(points[:, None] - points, axis=2)
    return result


def absolute_orientations(first: Float64Array, second: Float64Array) -> Float64Array:
    """The rigid motions (K, 4, 4) that bring points (K, N, 3) closest to others."""
    from_mean, to_mean = first.mean(axis=1, keepdims=True), second.mean(axis=1, keepdims=True)
    left, _, right = np.linalg.svd((second - to_mean).transpose(0, 2, 1) @ (first - from_mean))
    left[:, :, 2] *= np.sign(np.linalg.det(left @ right))[:, None]
    motions = np.tile(np.eye(4), (len(first), 1, 1))
    motions[:, :3, :3] = left @ right
    motions[:, :3, 3] = (to_mean - from_mean @ motions[:, :3, :3].transpose(0, 2, 1))[:, 0]
    return motions
