"""Weak joints: where a part does not hang together, as pairs that triangles of pictures bear out say twice as much
against its poses as holds it there (minimum cut: Ford and Fulkerson, 1956).

Parts are joined one after the other, and the first joint between two look-alikes may be the wrong one. Whatever is true
then contradicts it, and is left over.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np
from scipy.sparse import coo_array
from scipy.sparse.csgraph import breadth_first_order, maximum_flow

from razer.arrays import BoolArray, Float64Array, IndexArray
from razer.geometry import inverse
from slam.backend.submaps.merge_hypotheses import MAJORITY
from slam.sparse.measured_pair import MeasuredPair, Numbers, same_poses, told_poses

MOST_ASKED = 12  # motions that poses do not bear out, of the heaviest pairs, that may cut a part
SURE_SUPPORT = 2.0  # by triangles, from which a pair counts in full; without any it does not count
MOSTLY = 0.5  # share of the weight of pairs that say one thing that triangles must bear out, as false ones say it, too
FEWEST = 2  # pictures on each side: a single one moves by itself, see `Reassignment`
TAKEN_NEXT = 1e5  # weight of a pair of pictures taken one after the other, which nothing cuts
PER_UNIT = 10  # of the whole numbers that flows are made of


def weak_joint(
    pairs: Sequence[MeasuredPair], poses: Mapping[int, Float64Array], support: Mapping[Numbers, float]
) -> set[int] | None:
    """The pictures on one side of a joint of a part that is too weak; None where there is none.

    Args:
        pairs: all within the part.
        poses: part_from_picture (4, 4) of its pictures.
        support: what triangles say of each pair, see `pair_support`.
    """
    if not pairs:
        return None
    told, placed = told_poses(pairs, poses)
    is_held, weights = same_poses(told, placed), _weights(pairs, support)
    numbers, ends = np.unique(np.array([pair.ends for pair in pairs]), return_inverse=True)
    ends = ends.reshape(-1, 2)
    left = ~is_held & (weights > 0)
    for _ in range(MOST_ASKED):
        n = int(np.where(left, weights, -1.0).argmax())
        if not left[n]:
            break
        away = told[n] @ inverse(placed[n])
        alike = ~is_held & (same_poses(told, away @ placed) | same_poses(away @ told, placed))
        left &= ~alike
        left[n] = False
        side = _near_side(ends[is_held], weights[is_held], len(numbers), ends[n])
        spans = side[ends[:, 0]] != side[ends[:, 1]]
        say_so = float(weights[alike & spans].sum())
        most = sum(pair.weight for pair, is_one in zip(pairs, alike & spans, strict=True) if is_one)
        is_weak = say_so > max(MAJORITY * float(weights[is_held & spans].sum()), MOSTLY * most)
        if is_weak and min(side.sum(), (~side).sum()) >= FEWEST:
            return set(numbers[side].tolist())
    return None


def _weights(pairs: Sequence[MeasuredPair], support: Mapping[Numbers, float]) -> Float64Array:
    """How much each pair (N,) says, as far as triangles bear it out."""
    shares = np.clip([support[pair.ends] / SURE_SUPPORT for pair in pairs], 0, 1)
    return np.array([pair.weight for pair in pairs]) * shares + TAKEN_NEXT * np.array([pair.is_next for pair in pairs])


def _near_side(ends: IndexArray, weights: Float64Array, n_pictures: int, cut: IndexArray) -> BoolArray:
    """Which pictures (N,) are on the first one's side of the least cut between two of them, through edges between
    `ends` (E, 2)."""
    rows, columns = np.concatenate([ends, ends[:, ::-1]]).T
    capacities = np.maximum(np.rint(PER_UNIT * np.tile(weights, 2)), 1).astype(np.int32)
    network = coo_array((capacities, (rows, columns)), shape=(n_pictures, n_pictures)).tocsr()
    left = network - maximum_flow(network, int(cut[0]), int(cut[1])).flow
    left.data = np.maximum(left.data, 0)
    left.eliminate_zeros()
    side = np.zeros(n_pictures, bool)
    side[breadth_first_order(left, int(cut[0]), return_predecessors=False)] = True
    return side
