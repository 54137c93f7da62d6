"""Loop gate: whether the drift of the way between two keyframes may account for a motion measured between them.

Most ways drift by little, and what would need more is a place that looks alike. Where tracking hardly knew how the
camera moved, in front of a blank wall, drift is as much as it says itself.
"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from scipy.sparse import coo_array
from scipy.sparse.csgraph import dijkstra

from razer.arrays import Float64Array, IndexArray
from razer.geometry import inverse
from slam.backend.pose_graph import PoseGraph
from slam.config import LoopClosureSettings
from slam.frontend.keyframes import Keyframe
from slam.pose_edge import PoseEdge, edge_information, offset
from slam.se3 import adjoint, angle_deg, length_m, turn_rad

# Of those that edges count with, which are some five times too large, and three times too small for long ways, as
# registrations one after the other err alike.
MAX_SIGMAS = 2.0


def plausible(a: Keyframe, b: Keyframe, a_from_b: Float64Array, settings: LoopClosureSettings) -> bool:
    """Whether as much drift as any way has may account for a motion measured between two keyframes.

    Args:
        a: one keyframe.
        b: the other.
        a_from_b: (4, 4) as measured.
        settings: how much drift there may be.
    """
    way_m = abs(b.travelled_m - a.travelled_m)
    off = offset(a.world_from_camera, b.world_from_camera, a_from_b)
    return (
        length_m(off) <= settings.drift_m + settings.drift_m_per_m * way_m
        and angle_deg(off) <= settings.drift_deg + settings.drift_deg_per_m * way_m
    )


def is_within_uncertainty(edge: PoseEdge, graph: PoseGraph) -> bool:
    """Whether an edge is no farther off the poses of a graph than the edges along the surest way between its keyframes
    leave open (a validation gate: Bar-Shalom and Fortmann 1988). Where no way leads from one to the other it is not."""
    way = _surest_way(edge.a, edge.b, graph)
    if way is None:
        return False
    off = offset(graph.poses[edge.a], graph.poses[edge.b], edge.a_from_b)
    twist = np.concatenate([turn_rad(off), off[:3, 3]])
    covariance = sum((_covariance_at(edge.b, step, graph) for step in way), np.zeros((6, 6)))
    return float(np.sqrt(twist @ np.linalg.solve(covariance, twist))) <= MAX_SIGMAS


def _covariance_at(number: int, edge: PoseEdge, graph: PoseGraph) -> Float64Array:
    """That by which an edge leaves open (6, 6) where a keyframe is, along the axes of this one."""
    moved = adjoint(inverse(graph.poses[number]) @ graph.poses[edge.b])
    covariance: Float64Array = moved @ np.linalg.inv(edge_information(edge)) @ moved.T
    return covariance


def _surest_way(a: int, b: int, graph: PoseGraph) -> list[PoseEdge] | None:
    """The edges of the way of least variance from one keyframe to another (Dijkstra 1959); None where there is none."""
    surest = dict[tuple[int, int], PoseEdge]()
    for edge in sorted(graph.edges, key=lambda edge: edge.variance_m2):
        surest.setdefault((edge.a, edge.b), edge)
    ends = np.array(list(surest), np.int64).reshape(len(surest), 2)
    variances = [edge.variance_m2 for edge in surest.values()]
    table = coo_array((variances, ends.T), (max(graph.poses) + 1,) * 2)
    length, before = dijkstra(table, directed=False, indices=a, return_predecessors=True)
    return [surest[min(step), max(step)] for step in _steps(before, b)] if np.isfinite(length[b]) else None


def _steps(before: IndexArray, end: int) -> Iterator[tuple[int, int]]:
    while before[end] >= 0:
        yield int(before[end]), end
        end = int(before[end])
