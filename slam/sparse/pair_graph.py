"""Graphs of pictures and the edges between them: their poses as all edges have them, and what these tie together."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components

from razer.arrays import Float64Array, IndexArray
from slam.backend.pose_graph import PoseGraph
from slam.pose_edge import PoseEdge


def smoothed(poses: Mapping[int, Float64Array], edges: Sequence[PoseEdge]) -> Mapping[int, Float64Array]:
    """Poses (4, 4) by picture as all edges have them, the first one staying where it is."""
    graph = PoseGraph(fixed=min(poses))
    for number in sorted(poses):
        graph.add_keyframe(number, poses[number])
    for edge in edges:
        graph.add_edge(edge)
    return graph.smooth()


def components(n_keyframes: int, edges: Sequence[PoseEdge]) -> IndexArray:
    """Which keyframes (K,) edges tie together, by the number of their component."""
    ends = np.array([(edge.a, edge.b) for edge in edges], np.int64).reshape(-1, 2)
    table = coo_array((np.ones(len(ends)), (ends[:, 0], ends[:, 1])), shape=(n_keyframes, n_keyframes))
    return connected_components(table, directed=False)[1].astype(np.intp)
