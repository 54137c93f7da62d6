"""Nearest-neighbour label transfer between the vertices of two surfaces."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.spatial import cKDTree

from razer.arrays import BoolArray, Float64Array, FloatArray, Int64Array, IntArray

_REACH = 1.001  # of the limit of distance, within which neighbours are compared exactly
_SPARE = 4  # neighbours queried beyond k, so that most ties at the k-th are resolved at once


@dataclass(frozen=True, slots=True)
class Neighbours:
    """The k nearest of P source points of each of V points: index (V, k), nearest first; P where there is none."""

    index: Int64Array
    n_source: int

    def labels(self, source_labels: IntArray) -> Int64Array:
        """The label (V,) that most of the neighbours bear of (P,) source labels, the lowest of equally frequent ones;
        0 where there is no neighbour."""
        padded = np.append(np.asarray(source_labels, np.int64), 0)
        votes = padded[self.index]
        return votes[:, 0] if votes.shape[1] == 1 else _majority(votes, self.index < self.n_source)


def nearest_vertices(
    source: FloatArray,
    points: FloatArray,
    k: int = 1,
    max_distance_m: float | None = None,
    among: BoolArray | None = None,
) -> Neighbours:
    """The k source points nearest to each point.

    Distances are compared as squares, dx^2 + dy^2 + dz^2 in float64. Of equally near points the lower number comes
    first; with k = 1 a source point at the very place and with the very number of the point comes before it, so that a
    surface carried to itself stays as it is even where vertices coincide.

    Args:
        source: (P, 3), points to search, metres.
        points: (V, 3), points to find neighbours of, metres.
        k: neighbours for each point.
        max_distance_m: neighbours farther than this are left out; None: no limit.
        among: (P,), the source points to search; None: all.
    """
    source, points = np.asarray(source, np.float64), np.asarray(points, np.float64)
    chosen = np.arange(len(source)) if among is None else np.flatnonzero(among)
    if len(chosen) == 0 or len(points) == 0:
        return Neighbours(np.full((len(points), k), len(source), np.int64), len(source))
    tree, reach_m = cKDTree(source[chosen]), np.inf if max_distance_m is None else max_distance_m * _REACH
    # Points far from all are looked up once: order among their neighbours would be found out in vain.
    near = np.flatnonzero(np.isfinite(tree.query(points, distance_upper_bound=reach_m)[0]))
    index = np.full((len(points), k), len(source), np.int64)
    nearest = _ordered(tree, source[chosen], points[near], k, k + (_SPARE if k > 1 else 1))
    index[near] = np.append(chosen, len(source))[nearest]
    if k == 1:
        own = chosen[chosen < len(points)]
        same = own[(source[own] == points[own]).all(axis=1)]
        index[same, 0] = same
    if max_distance_m is not None:
        # A distance of exactly the limit is within it, whatever its square rounds to.
        is_far = np.sqrt(_squares(source, points, index)) > max_distance_m
        index[is_far] = len(source)
    return Neighbours(index, len(source))


def transfer_labels(
    predicted_vertices: FloatArray,
    predicted_ids: IntArray,
    truth_vertices: FloatArray,
    max_distance_m: float | None = 0.05,
    k: int = 1,
) -> Int64Array:
    """The label (V,) of each truth vertex: that of the nearest predicted vertex, or of most of the k nearest.

    Args:
        predicted_vertices: (P, 3), metres.
        predicted_ids: (P,), their labels.
        truth_vertices: (V, 3), metres.
        max_distance_m: predicted vertices farther than this carry no label; None: no limit. 0 where none is left.
        k: neighbours that vote; a tie goes to the lower label.
    """
    return nearest_vertices(predicted_vertices, truth_vertices, k, max_distance_m).labels(predicted_ids)


def _ordered(tree: cKDTree, source: FloatArray, points: FloatArray, k: int, n_queried: int) -> Int64Array:
    """The k nearest of each point, ordered by distance, then by number, out of the `n_queried` nearest or more."""
    _, nearest = tree.query(points, k=list(range(1, min(n_queried, len(source)) + 1)))
    squares = _squares(source, points, nearest)
    chosen = np.lexsort((nearest, squares), axis=1)[:, :k]
    index = np.take_along_axis(nearest, chosen, axis=1).astype(np.int64)
    if n_queried < len(source):
        # More points may lie as far as the k-th than were queried; the tree's distances may differ by rounding.
        kth = np.take_along_axis(squares, chosen[:, -1:], axis=1)[:, 0]
        undecided = np.flatnonzero(squares.max(axis=1) <= kth * (1 + 1e-12))
        if len(undecided):
            index[undecided] = _ordered(tree, source, points[undecided], k, 2 * n_queried)
    missing = max(k - index.shape[1], 0)
    return np.pad(index, ((0, 0), (0, missing)), constant_values=len(source))


def _squares(source: FloatArray, points: FloatArray, index: Int64Array) -> Float64Array:
    """Squared distances (V, k); infinite where there is no neighbour."""
    known = np.minimum(index, len(source) - 1)
    total = np.zeros(index.shape)
    for axis in range(3):
        total += (source[known, axis] - points[:, axis, None]) ** 2
    return np.where(index < len(source), total, np.inf)


def _majority(labels: Int64Array, valid: BoolArray) -> Int64Array:
    """The most frequent valid label of each row, the lowest of equally frequent ones; 0 for rows without any."""
    votes = ((labels[:, :, None] == labels[:, None, :]) & valid[:, None, :]).sum(axis=2) * valid
    best = np.where(votes == votes.max(axis=1, keepdims=True), labels, np.iinfo(np.int64).max).min(axis=1)
    return np.where(valid.any(axis=1), best, 0)
