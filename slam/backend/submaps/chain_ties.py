"""Chain ties: which keyframes move along with an odometry chain that proves to lie elsewhere."""

from __future__ import annotations

import numpy as np
from scipy.sparse import coo_matrix
from scipy.sparse.csgraph import connected_components

from razer.arrays import IndexArray, Int64Array


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
