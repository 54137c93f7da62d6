"""Rigid matches: features that lie as far from each other in one view as in the other, whatever moved between the two
(pairwise consistency, as in Leordeanu and Hebert, ICCV 2005), and the motion they say by absolute orientation (Horn,
1987).

Far cheaper than a registration, and a start for one, from views 50 degrees or a metre apart, too.
"""

from __future__ import annotations

from functools import cached_property
from typing import NamedTuple

import numpy as np
from scipy.spatial.distance import cdist

from razer.arrays import BoolArray, Float64Array, IndexArray
from slam.frontend.features import Features
from slam.frontend.gauss_newton.correspondences import MIN_INLIERS
from slam.frontend.wide_features import RootPair, match_wide_features

# Matched features whose distance is the same in both views but for so much, some of it for each metre of depth, may
# belong to one scene.
SAME_DISTANCE_M, SAME_DISTANCE_SHARE = 0.02, 0.02
MOST = 0.6  # share of a set that each of it must agree with: matches that are false agree with few
# Features that a motion explains, of views of one place; PnP finds no other then, at ten times the cost.
ENOUGH_EXPLAINED = 8
FEW_EXPLAINED = 4  # say where to look, and may agree by chance
LEAST = 3  # points, that a motion is known by
LEAST_INFORMATION = 1e-3  # along any axis, 1 / rad^2 and 1 / m^2
ROUNDS = 3  # of leaving out those that do not, and of taking in those that the motion explains


class RigidMotion(NamedTuple):
    """target_from_source (4, 4), roughly, how many features it explains, what these tell of it: information (6, 6) of a
    left perturbation (rotation, shift), and whether they are enough to be no chance."""

    target_from_source: Float64Array
    n_explained: int
    information: Float64Array
    is_sure: bool = True


class RigidMatches:
    """The largest set of matched features of two views that agree with one of them. `pairs`: all matches (M, 2) of
    (target, source) features, those without a depth in the source, too. `roots`: see `match_wide_features`."""

    def __init__(self, target: Features, source: Features, roots: RootPair | None = None) -> None:
        self.pairs = match_wide_features(target, source, roots)
        t, s = self.pairs.T
        t, s = (numbers[source.depth_m[s] > 0] for numbers in (t, s))
        self._there, self._here = _points(target, t), _points(source, s)
        depth_m = np.maximum(target.depth_m[t], source.depth_m[s])
        self._margin_m = SAME_DISTANCE_M + SAME_DISTANCE_SHARE * depth_m

    @property
    def n_agreeing(self) -> int:
        """How many matches agree with one of them, itself included; of views that share nothing hardly any have a
        dozen."""
        return len(self._agreeing)

    @cached_property
    def _agreeing(self) -> IndexArray:
        """The numbers of these."""
        n_agreeing = self._agree.sum(axis=1)
        return np.flatnonzero(self._agree[int(n_agreeing.argmax())]) if len(n_agreeing) else np.zeros(0, np.intp)

    @cached_property
    def _agree(self) -> BoolArray:
        """Which matches (M, M) are as far from each other in both views."""
        margin_m = np.maximum(self._margin_m, self._margin_m[:, None])
        agree: BoolArray = np.abs(cdist(self._there, self._there) - cdist(self._here, self._here)) < margin_m
        return agree

    def motion(self) -> Float64Array:
        """target_from_source (4, 4) as those have it that agree with most others, and then all that it explains; of
        three features at least."""
        return self._best[0]

    @property
    def n_explained(self) -> int:
        """How many features the motion brings to where the target saw them."""
        return int(self._best[1].sum())

    @property
    def information(self) -> Float64Array:
        """What the features that it explains tell of the motion, each known to its margin: (6, 6), rotation first."""
        explained = self._best[1]
        points, precision = self._here[explained], 1 / self._margin_m[explained]
        moved = points @ self._best[0][:3, :3].T + self._best[0][:3, 3]
        turned = np.cross(np.eye(3)[None], moved[:, None])  # d (turn x point) / d turn, axis by axis
        jacobian = np.concatenate([turned, np.broadcast_to(np.eye(3), turned.shape)], axis=1)
        weighted = (jacobian * precision[:, None, None]).transpose(0, 2, 1).reshape(-1, 6)
        result: Float64Array = weighted.T @ weighted + LEAST_INFORMATION * np.eye(6)
        return result

    @property
    def is_sure(self) -> bool:
        """Whether enough features agree, and the motion explains enough."""
        n_matches = len(self._margin_m)
        return n_matches >= MIN_INLIERS and self.n_agreeing >= MIN_INLIERS and self.n_explained >= ENOUGH_EXPLAINED

    @property
    def is_hint(self) -> bool:
        """Whether some features agree, which may be chance."""
        return self.n_agreeing >= LEAST and self.n_explained >= FEW_EXPLAINED

    @cached_property
    def _best(self) -> tuple[Float64Array, BoolArray]:
        """The motion that explains most, and what it explains (M,)."""
        best = self._explained(_consistent(self._agreeing, self._agree))
        for _ in range(ROUNDS):
            if best[1].sum() < LEAST:
                break
            better = self._explained(np.flatnonzero(best[1]))
            if better[1].sum() <= best[1].sum():
                break
            best = better
        return best

    def _explained(self, numbers: IndexArray) -> tuple[Float64Array, BoolArray]:
        motion = absolute_orientations(self._here[None, numbers], self._there[None, numbers])[0]
        off_m = np.linalg.norm(self._here @ motion[:3, :3].T + motion[:3, 3] - self._there, axis=1)
        return motion, off_m < self._margin_m


def _consistent(numbers: IndexArray, agree: BoolArray) -> IndexArray:
    for _ in range(ROUNDS):
        fewer = numbers[agree[np.ix_(numbers, numbers)].mean(axis=1) >= MOST] if len(numbers) else numbers
        if len(fewer) < LEAST:
            break
        numbers = fewer
    return numbers


def _points(features: Features, numbers: IndexArray) -> Float64Array:
    rays = np.column_stack([features.rays[numbers], np.ones(len(numbers))])
    return rays.astype(np.float64) * features.depth_m[numbers, None]


def absolute_orientations(first: Float64Array, second: Float64Array) -> Float64Array:
    """The rigid motions (K, 4, 4) that bring points (K, N, 3) closest to others."""
    from_mean, to_mean = first.mean(axis=1, keepdims=True), second.mean(axis=1, keepdims=True)
    left, _, right = np.linalg.svd((second - to_mean).transpose(0, 2, 1) @ (first - from_mean))
    left[:, :, 2] *= np.sign(np.linalg.det(left @ right))[:, None]
    motions = np.tile(np.eye(4), (len(first), 1, 1))
    motions[:, :3, :3] = left @ right
    motions[:, :3, 3] = (to_mean - from_mean @ motions[:, :3, :3].transpose(0, 2, 1))[:, 0]
    return motions
