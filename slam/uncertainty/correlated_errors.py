"""Correlated errors: registrations one after the other share a view, and err alike by half of what they err.

Each view brings half of the error of a registration, so that those that share one correlate by a half, and those
farther apart by half of that again. Errors that add up over n of them have not n times the variance of one, but with
the correlation r = 1/2

    n (1 + r) / (1 - r) - 2 r (1 - r^n) / (1 - r)^2

times that: as much as if they were independent for one, three times as much for many (the variance of a mean of a
first-order autoregressive process, Bayley and Hammersley 1946).
"""

from __future__ import annotations

import numpy as np
from scipy.sparse import coo_array
from scipy.sparse.csgraph import dijkstra

from razer.arrays import Float64Array
from slam.backend.pose_graph import PoseGraph

SHARED_VIEW = 0.5  # correlation of two registrations that have one of their two views in common


def error_growth(graph: PoseGraph) -> Float64Array:
    """How many times the variance of each keyframe, by number (K,), is what it would be if all registrations erred by
    themselves: by how many of them it is away from the keyframe that is the world. Where nothing ties it to that one,
    or none is, as many as there may be."""
    n_keyframes = max(graph.poses, default=-1) + 1
    n_edges = np.full(n_keyframes, np.inf)
    if graph.fixed is not None and n_keyframes:
        ends, _ = graph.edge_table()
        table = coo_array((np.ones(len(ends)), (ends[:, 0], ends[:, 1])), shape=(n_keyframes, n_keyframes))
        n_edges = dijkstra(table, directed=False, unweighted=True, indices=graph.fixed)
    return growth(n_edges)


def growth(n_edges: Float64Array) -> Float64Array:
    """The same for so many registrations (K,), infinitely many included."""
    r, n = SHARED_VIEW, np.maximum(n_edges, 1.0)
    result: Float64Array = (1 + r) / (1 - r) - 2 * r * (1 - r**n) / (n * (1 - r) ** 2)
    return result
