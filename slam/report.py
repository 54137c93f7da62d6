"""Reports of the pose estimation, for whoever watches or keeps them: plain values, cheap to gather and to send."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from razer.arrays import BoolArray, Float64Array, Int64Array
from slam.frontend.icp import IcpResult
from slam.frontend.keyframes import Keyframe

if TYPE_CHECKING:  # GTSAM takes 40 MB, which runs under given poses never need
    from slam.backend.pose_graph import PoseEdge


@dataclass(frozen=True, slots=True)
class TrackingQuality:
    """How well a frame was registered to a keyframe: features that agree; the share of its depth readings that lie on
    the keyframe's (agreement), and the share of all its points that do (score); standard deviations along the least
    certain axes."""

    n_features: int
    agreement: float
    score: float
    sigma_rotation_rad: float
    sigma_shift_m: float

    @classmethod
    def of(cls, result: IcpResult) -> TrackingQuality:
        """The figures of a registration."""
        return cls(result.n_features, result.agreement, result.score, *result.sigma)


@dataclass(frozen=True, slots=True)
class GraphReport:
    """The keyframes of the world, in the order of taking, and the edges between them.

    frames (K,) indices and stamps (K,) seconds of the keyframes' frames; world_from_camera (K, 4, 4); edges (E, 2)
    rows of keyframes; is_odometry (E,), whether tracking led from one to the other; n_loops, edges that close a loop;
    n_unanchored, keyframes of submaps that are not merged with it. covariances (6, 6) by frame index, of those
    keyframes that it was computed for: of the small motion (rotation, radians; shift, metres), along the camera's own
    axes, that takes the estimated pose to the true one.
    """

    frames: Int64Array
    stamps: Float64Array
    world_from_camera: Float64Array
    edges: Int64Array
    is_odometry: BoolArray
    n_loops: int
    n_unanchored: int
    covariances: Mapping[int, Float64Array]

    @classmethod
    def of(
        cls,
        keyframes: Sequence[Keyframe],
        edges: Sequence[PoseEdge],
        n_loops: int,
        covariances: Mapping[int, Float64Array],
    ) -> GraphReport:
        """The present state, from keyframes known by number.

        Args:
            keyframes: all keyframes, in the order of their numbers.
            edges: all edges of the pose graph.
            n_loops: edges that close a loop.
            covariances: (6, 6) by keyframe.
        """
        anchored = [keyframe for keyframe in keyframes if keyframe.submap == 0]
        row = {keyframe.number: n for n, keyframe in enumerate(anchored)}
        between = [edge for edge in edges if edge.a in row and edge.b in row]
        return cls(
            frames=np.array([k.view.index for k in anchored], np.int64),
            stamps=np.array([k.view.stamp for k in anchored], np.float64),
            world_from_camera=np.array([k.world_from_camera for k in anchored]).reshape(-1, 4, 4),
            edges=np.array([(row[e.a], row[e.b]) for e in between], np.int64).reshape(-1, 2),
            is_odometry=np.array([e.is_odometry for e in between], bool),
            n_loops=n_loops,
            n_unanchored=len(keyframes) - len(anchored),
            covariances={keyframes[n].view.index: c for n, c in covariances.items() if n in row},
        )


@dataclass(frozen=True, slots=True)
class PoseReport:
    """Where the last frame is as known now (None: lost, or unanchored), how it was registered (None: it was not, or
    begins a submap of its own), and the pose graph if it was optimised since the last report."""

    world_from_camera: Float64Array | None
    tracking: TrackingQuality | None
    graph: GraphReport | None
