"""Chain ties: which keyframes move along with an odometry chain that proves to lie elsewhere, and how far keyframes are
from what ties two parts together."""

from __future__ import annotations

import numpy as np
from scipy.sparse import coo_matrix
from scipy.sparse.csgraph import connected_components, dijkstra

from razer.arrays import Float64Array, IndexArray, Int64Array


def hanging_on(chain: int, chains: Int64Array, ends: Int64Array) -> IndexArray:
    """The keyframes of a chain, and those of later ones that hang on it alone: not, without it, on an earlier one.

    Args:
        chain: which.
        chains: (K,) that each keyframe belongs to.
        ends: (E, 2) keyframes that edges tie.
    """
    of = np.sort(chains[ends], axis=1)
    kept = ends[(of[:, 1] != chain) | (of[:, 0] == chain)]
    ties = coo_matrix((np.ones(len(kept)), kept.T), shape=(len(chains), len(chains)))
    _, part = connected_components(ties, directed=False)
    hanging = np.flatnonzero(np.isin(part, part[chains == chain]))
    return hanging if (chains[hanging] >= chain).all() else np.flatnonzero(chains == chain)


def way_to_ties(ties: Int64Array, positions: Float64Array, ends: Int64Array) -> Float64Array:
    """How far (K,) each keyframe is from the nearest that a tie ends at, along edges, metres: by how much of a way its
    place may have drifted from where the tie says. Infinite where no way leads there.

    Args:
        ties: (T, 2) keyframes, one at least.
        positions: (K, 3) of all keyframes, metres.
        ends: (E, 2) keyframes that edges join, without the ties.
    """
    ends = np.unique(np.sort(ends, axis=1), axis=0)
    lengths = np.linalg.norm(positions[ends[:, 0]] - positions[ends[:, 1]], axis=1)
    # Nothing is no edge to scipy, so that a camera that only turned goes a tiny way.
    table = coo_matrix((np.maximum(lengths, 1e-9), ends.T), shape=(len(positions), len(positions)))
    way: Float64Array = dijkstra(table.tocsr(), directed=False, indices=np.unique(ties), min_only=True)
    return way
