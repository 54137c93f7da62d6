"""Pose reporter: what is told of the last frame, and of the pose graph whenever its poses have changed."""

from __future__ import annotations

from slam.backend.keyframe_map import KeyframeMap
from slam.frontend.icp import IcpResult
from slam.located_frames import LocatedFrames
from slam.report import GraphReport, PoseReport, PoseUncertainty, TrackingQuality
from slam.uncertainty.open_directions import OpenDirections
from slam.uncertainty.pose_uncertainty import CovarianceScale, final_uncertainty, live_covariance


class PoseReporter:
    """Reports on frames located in front of the keyframes of a map. `is_finished`: whether no more will come."""

    def __init__(self, keyframe_map: KeyframeMap, located: LocatedFrames) -> None:
        self._map, self._located = keyframe_map, located
        self._index: int | None = None  # of the last frame
        self._version = 0  # of the map's poses, when the graph was reported last
        self._result: IcpResult | None = None
        self._scale, self._open = CovarianceScale(), OpenDirections()
        self.is_finished = False

    def begin(self, index: int) -> None:
        """The next frame is looked at."""
        self._index, self._result = index, None

    def registered(self, result: IcpResult | None) -> None:
        """How it was registered; None = it was not."""
        self._result = result
        if result is not None and self._index is not None:
            self._open.see(self._index, result)

    def report(self) -> PoseReport:
        """How the last frame was registered; with it, after an optimisation, the pose graph, and the covariance of the
        newest keyframe, or of all once the estimation is finished."""
        graph = None
        if self._version != self._map.version:
            graph = GraphReport.of(self._map.keyframes, self._map.graph, self._map.n_loops, self._uncertainty())
            self._version = self._map.version
        pose = None if self._index is None else self._located.reported(self._index)
        return PoseReport(pose, None if self._result is None else TrackingQuality.of(self._result), graph)

    def _uncertainty(self) -> PoseUncertainty:
        graph = self._map.graph
        if not self.is_finished:
            newest = len(self._map.keyframes) - 1
            covariance = live_covariance(graph, newest, self._scale.of(graph))
            return PoseUncertainty({} if covariance is None else {newest: covariance})
        unit = self._scale.measure(graph)
        return final_uncertainty(graph, unit, self._open.stretches(unit))
