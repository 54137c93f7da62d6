"""Solved poses: what `SparseSystem` found, handed out frame by frame as if it came with the frames."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from razer.arrays import Pose
from razer.frame import Frame
from slam.report import GraphReport, PoseReport, TrackingQuality
from slam.sparse.sparse_system import SparseSystem


@dataclass
class SolvedPoses:
    """Final poses world_from_camera (4, 4) of frames by index, how well each was registered, and the pose graph."""

    poses: Mapping[int, Pose]
    quality: Mapping[int, TrackingQuality]
    graph: GraphReport | None
    last: int | None = None  # frame that was asked for
    is_reported: bool = False  # whether the graph was reported

    @classmethod
    def of(cls, solved: SparseSystem) -> SolvedPoses:
        """Those of a system that has finished."""
        return cls(solved.trajectory(), dict(solved.quality), solved.report().graph)

    def locate(self, frame: Frame) -> Pose | None:
        """world_from_camera of a frame; None where it is not known."""
        self.last = frame.index
        return self.poses.get(frame.index)

    def corrections(self) -> Mapping[int, Pose | None]:
        """Nothing: these poses are final."""
        return {}

    def finish(self) -> None:
        """The graph is reported once more, as the finished one."""
        self.is_reported = False

    def report(self) -> PoseReport:
        """How the last frame was registered, and with the first frame and in the end the pose graph."""
        graph = None if self.is_reported else self.graph
        self.is_reported = True
        pose = None if self.last is None else self.poses.get(self.last)
        return PoseReport(pose, None if pose is None or self.last is None else self.quality.get(self.last), graph)
