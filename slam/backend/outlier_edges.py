"""Outlier edges: those between keyframes that the finished pose graph contradicts."""

from __future__ import annotations

from collections.abc import Mapping

from razer.arrays import Float64Array
from slam.backend.pose_graph import mahalanobis
from slam.pose_edge import PoseEdge, offset
from slam.se3 import angle_deg, length_m

MAX_MAHALANOBIS = 15.0  # sigmas
# However unsure of itself, an edge so far off ties what lies elsewhere: along a wall that hardly holds it, it slid.
MAX_OFF_M, MAX_OFF_DEG = 0.25, 5.0


def is_outlier(edge: PoseEdge, poses: Mapping[int, Float64Array]) -> bool:
    """Whether the poses world_from_camera (4, 4) of a finished graph, by keyframe, contradict an edge."""
    off = offset(poses[edge.a], poses[edge.b], edge.a_from_b)
    is_far = length_m(off) > MAX_OFF_M or angle_deg(off) > MAX_OFF_DEG
    return is_far or mahalanobis(edge, poses) > MAX_MAHALANOBIS
