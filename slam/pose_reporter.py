"""Pose reporter: what is told of the last frame, and of the pose graph whenever its poses have changed."""

from __future__ import annotations

from collections.abc import Mapping

from razer.arrays import Float64Array
from slam.backend.keyframe_map import KeyframeMap
from slam.frontend.icp import IcpResult
from slam.located_frames import LocatedFrames
from slam.report import GraphReport, PoseReport, TrackingQuality


class PoseReporter:
    """Reports on frames located in front of the keyframes of a map. `result`: how the last one was registered;
    `is_finished`: whether no more will come."""

    def __init__(self, keyframe_map: KeyframeMap, located: LocatedFrames) -> None:
        self._map, self._located = keyframe_map, located
        self._index: int | None = None  # of the last frame
        self._version = 0  # of the map's poses, when the graph was reported last
        self.result: IcpResult | None = None
        self.is_finished = False

    def begin(self, index: int) -> None:
        """The next frame is looked at."""
        self._index, self.result = index, None

    def report(self) -> PoseReport:
        """How the last frame was registered; with it, after an optimisation, the pose graph, and the covariance of the
        newest keyframe, or of all once the estimation is finished."""
        graph = None
        if self._version != self._map.version:
            graph = GraphReport.of(self._map.keyframes, self._map.graph, self._map.n_loops, self._covariances())
            self._version = self._map.version
        pose = None if self._index is None else self._located.reported(self._index)
        return PoseReport(pose, None if self.result is None else TrackingQuality.of(self.result), graph)

    def _covariances(self) -> Mapping[int, Float64Array]:
        if self.is_finished:
            return self._map.graph.covariances()
        newest = len(self._map.keyframes) - 1
        covariance = self._map.graph.covariance(newest)
        return {} if covariance is None else {newest: covariance}
