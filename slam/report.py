"""Reports of the pose estimation, for whoever watches or keeps them: plain values, cheap to gather and to send."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import TYPE_CHECKING

import numpy as np

from razer.arrays import BoolArray, Float64Array, Int64Array
from slam.frontend.icp import IcpResult
from slam.frontend.keyframes import Keyframes

if TYPE_CHECKING:  # GTSAM takes 40 MB, which runs under given poses never need
    from slam.backend.pose_graph import PoseGraph


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
class OpenStretch:
    """Frames, from the index of the first to that of the last, in which a direction was open, and the axis (3,) of it
    along the camera's own axes, of length one."""

    first: int
    last: int
    axis: Float64Array

    def describe(self) -> str:
        """In one plain line."""
        frames = f"frames {self.first} to {self.last}"
        way = ("sideways", "up or down", "along its view")[int(np.abs(self.axis).argmax())]
        return f"{frames}: nothing in view says how far the camera moved {way}, and poses there may be off"


@dataclass(frozen=True, slots=True)
class PoseUncertainty:
    """How uncertain poses are, by keyframe where nothing else is said: covariances (6, 6) as in GraphReport;
    local_sigmas_m, standard deviations in metres of what is seen 2 m ahead, in front of what neighbours see; open,
    stretches of frames."""

    covariances: Mapping[int, Float64Array]
    local_sigmas_m: Mapping[int, float] = field(default_factory=dict)
    open: tuple[OpenStretch, ...] = ()


@dataclass(frozen=True, slots=True)
class GraphReport:
    """The keyframes of the world, in the order of taking, and the edges between them.

    frames (K,) indices and stamps (K,) seconds of the keyframes' frames; world_from_camera (K, 4, 4); edges (E, 2)
    rows of keyframes; is_odometry (E,), whether tracking led from one to the other; n_loops, edges that close a loop;
    n_unanchored, keyframes of submaps that are not merged with it. covariances (6, 6) by frame index, of those
    keyframes that it was computed for: of the small motion (rotation, radians; shift, metres), along the camera's own
    axes, that takes the estimated pose to the true one. Once the estimation is finished, local_sigmas_m, by frame index
    as well, are standard deviations, metres, of what a keyframe sees 2 m ahead among what its neighbours see, and open
    are the stretches in which a direction was open.
    """

    frames: Int64Array
    stamps: Float64Array
    world_from_camera: Float64Array
    edges: Int64Array
    is_odometry: BoolArray
    n_loops: int
    n_unanchored: int
    covariances: Mapping[int, Float64Array]
    local_sigmas_m: Mapping[int, float] = field(default_factory=dict)
    open: tuple[OpenStretch, ...] = ()

    @classmethod
    def of(cls, keyframes: Keyframes, graph: PoseGraph, n_loops: int, uncertainty: PoseUncertainty) -> GraphReport:
        """The present state, from keyframes known by number.

        Args:
            keyframes: all keyframes.
            graph: the pose graph over them.
            n_loops: edges that close a loop.
            uncertainty: of its poses.
        """
        is_anchored = keyframes.submaps() == 0
        row = np.cumsum(is_anchored) - 1
        anchored = [keyframes[n] for n in np.flatnonzero(is_anchored).tolist()]
        ends, is_odometry = graph.edge_table()
        between = is_anchored[ends].all(axis=1)
        frame_of = {n: keyframes[n].view.index for n in np.flatnonzero(is_anchored).tolist()}
        return cls(
            frames=np.array([k.view.index for k in anchored], np.int64),
            stamps=np.array([k.view.stamp for k in anchored], np.float64),
            world_from_camera=keyframes.poses()[is_anchored],
            edges=row[ends[between]],
            is_odometry=is_odometry[between],
            n_loops=n_loops,
            n_unanchored=len(keyframes) - len(anchored),
            covariances={frame_of[n]: c for n, c in uncertainty.covariances.items() if n in frame_of},
            local_sigmas_m={frame_of[n]: s for n, s in uncertainty.local_sigmas_m.items() if n in frame_of},
            open=uncertainty.open,
        )


@dataclass(frozen=True, slots=True)
class PoseReport:
    """Where the last frame is as known now (None: lost, or unanchored), how it was registered (None: it was not, or
    begins a submap of its own), and the pose graph if it was optimised since the last report."""

    world_from_camera: Float64Array | None
    tracking: TrackingQuality | None
    graph: GraphReport | None
