"""A hard walk followed by pose estimation, and its figures."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np

from app.benchmark.poses.calibration import nees_figures
from app.benchmark.poses.consistency import pose_nees
from app.benchmark.poses.false_ties import MergeWatch, count_false_edges
from app.benchmark.poses.known_view import seen_cells
from app.benchmark.poses.processor_time import ProcessorTime
from app.benchmark.poses.recovery import RecoveryWatch
from app.benchmark.poses.worlds.hard_walk import HardWalk, Shot
from razer.arrays import Float64Array, Pose
from razer.metrics.scene_pair import TimedPoses
from razer.metrics.trajectory_errors import trajectory_metrics
from slam.sparse.sparse_system import SparseSystem
from slam.system import SlamSystem

Figures = dict[str, float | int | None]


@dataclass
class FollowedWalk:
    """What pose estimation makes of a walk: true poses of the frames that show something and poses as known now, by
    frame; which were located in time; what was counted on the way; and what it took."""

    slam: SlamSystem | SparseSystem
    truth: dict[int, Pose] = field(default_factory=dict)
    poses: dict[int, Pose] = field(default_factory=dict)
    in_time: set[int] = field(default_factory=set)
    recovery: RecoveryWatch = field(default_factory=RecoveryWatch)
    merges: MergeWatch = field(default_factory=MergeWatch)
    time: ProcessorTime = field(default_factory=ProcessorTime)

    def see(self, shot: Shot) -> None:
        """Locate one more frame."""
        index, cells = shot.frame.index, None
        if shot.world_from_camera is not None:
            self.truth[index] = shot.world_from_camera
            cells = seen_cells(shot.frame, shot.world_from_camera)
            self.time.fuse(shot.frame, shot.world_from_camera)
        pose, corrections = self.time.of_frame(lambda: (self.slam.locate(shot.frame), self.slam.corrections()))
        if pose is not None:
            self.in_time.add(index)
        self._move({index: pose} | dict(corrections))
        if isinstance(self.slam, SlamSystem):  # else nothing is known in time
            self.recovery.see(index, cells, self.poses, self.truth)
        self.merges.see(self.slam.keyframes.all, self.truth)

    def finish(self) -> None:
        """Let the estimation come to its end."""
        self.time.of_end(self.slam.finish)
        self._move(self.time.of_end(self.slam.corrections))
        self.merges.see(self.slam.keyframes.all, self.truth)

    def _move(self, poses: Mapping[int, Pose | None]) -> None:
        for index, pose in poses.items():
            if pose is None:
                self.poses.pop(index, None)
            else:
                self.poses[index] = pose

    def figures(self, frames_per_s: float) -> Figures:
        """The figures of a finished walk; None where one does not apply, or for a camera that was not found again."""
        final, seeing = self._final(), max(len(self.truth), 1)
        return {
            "frames": len(self.truth),
            "share_tracked": round(len(final) / seeing, 4),
            "share_in_time": round(len(self.in_time & self.truth.keys()) / seeing, 4),
            "recoveries": len(self.recovery.frames_to_recover),
            "frames_to_recover": self.recovery.longest,
            "false_ties": self._false_edges() + self.merges.n_false,
            **_errors(self.truth, final, frames_per_s),
            **self.time.figures(),
            **nees_figures(self._nees()),
        }

    def _final(self) -> dict[int, Pose]:
        """Poses of frames that show something; those that are not finite say nothing of where the camera was."""
        trajectory = self.slam.trajectory().items()
        return {index: pose for index, pose in trajectory if index in self.truth and np.isfinite(pose).all()}

    def _false_edges(self) -> int:
        frames = [keyframe.view.index for keyframe in self.slam.keyframes.all]
        return count_false_edges(self.slam.graph.edges, frames, self.truth)

    def _nees(self) -> Float64Array:
        graph = self.slam.report().graph
        if graph is None:
            return np.zeros(0)
        poses = dict(zip(graph.frames.tolist(), graph.world_from_camera, strict=True))
        return pose_nees(poses, graph.covariances, self.truth)


def _errors(truth: Mapping[int, Pose], poses: Mapping[int, Pose], frames_per_s: float) -> Figures:
    """Absolute trajectory error, centimetres, and error of rotation, degrees, both root mean squares."""
    metrics = trajectory_metrics(_timed(truth, frames_per_s), _timed(poses, frames_per_s)) if poses else None
    if metrics is None:
        return {"ate_cm": None, "rotation_deg": None}
    return {"ate_cm": round(100 * metrics.ate_rmse_m, 2), "rotation_deg": round(metrics.rotation_rmse_deg, 2)}


def _timed(poses: Mapping[int, Pose], frames_per_s: float) -> TimedPoses:
    frames = sorted(poses)
    return TimedPoses(np.array(frames) / frames_per_s, np.stack([poses[frame] for frame in frames]))


def follow(walk: HardWalk, slam: SlamSystem | SparseSystem) -> FollowedWalk:
    """Follow a walk to its end."""
    followed = FollowedWalk(slam)
    for shot in walk:
        followed.see(shot)
    followed.finish()
    return followed
