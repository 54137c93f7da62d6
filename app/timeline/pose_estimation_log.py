"""Pose estimation on the timeline: trajectory, keyframes, pose graph, uncertainty, and where tracking was lost."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from app.timeline import entities
from app.timeline.config import TimelineConfig
from app.timeline.ellipsoids import position_ellipsoids
from app.timeline.rerun_log import RerunLog
from app.timeline.trajectory_lines import TrajectoryLines
from razer.arrays import Float64Array, Pose
from razer.geometry import inverse
from slam.report import GraphReport, PoseReport

WHOLE, NEWEST = "whole", "newest"  # parts of a trajectory: the second is what was added since the first was drawn
LINE_COLORS = {
    **{f"{entities.ESTIMATED}/{part}": (255, 160, 0) for part in (WHOLE, NEWEST)},
    **{f"{entities.GIVEN}/{part}": (40, 160, 60) for part in (WHOLE, NEWEST)},
    entities.ODOMETRY: (150, 150, 170),
    entities.CLOSURES: (200, 60, 200),
    entities.BEFORE: (214, 39, 40),
    entities.AFTER: (31, 111, 180),
}
EDGES = (entities.ODOMETRY, entities.CLOSURES)
SERIES = {
    entities.TRACKED: ["tracked"],
    entities.DEPTH_FOUND: ["score", "agreement"],
    entities.FEATURES_FOUND: ["features that agree"],
    entities.SIGMA: ["rotation, mrad", "shift, mm"],
    entities.GRAPH_SIZE: ["keyframes", "edges", "loops", "keyframes unanchored"],
    entities.TRACKING_MS: ["tracking, ms"],
}
PATH_RADIUS_POINTS, EDGE_RADIUS_POINTS = 1.5, 0.5  # there are many edges, and they lie on each other
KEYFRAME_COLOR, UNCERTAIN_COLOR = (255, 230, 60), (80, 200, 255)
KEYFRAME_RADIUS_POINTS = 2.5


class PoseEstimationLog:
    """Logs it frame by frame, each at the frame that `log` is at."""

    def __init__(self, log: RerunLog, config: TimelineConfig) -> None:
        self._log = log
        self._config = config
        self._estimated, self._given = TrajectoryLines(), TrajectoryLines()
        self._common: int | None = None  # the first frame that has both an estimated and a given pose
        self._n_logged = 0
        self._n_lost = 0
        self._keyframes: dict[int, Float64Array] = {}
        self._covariances: dict[int, Float64Array] = {}
        for entity, color in LINE_COLORS.items():
            log.line_style(entity, color, EDGE_RADIUS_POINTS if entity in EDGES else PATH_RADIUS_POINTS)
        for entity, names in SERIES.items():
            log.name_series(entity, names)

    def add_frame(self, index: int, report: PoseReport, given: Pose | None, pose_ms: float) -> None:
        """Log how a further frame was tracked.

        Args:
            index: of the frame.
            report: what was estimated of it.
            given: the pose (4, 4) that the frame itself came with.
            pose_ms: milliseconds that the estimation took.
        """
        self._estimated.add(index, report.world_from_camera)
        self._given.add(index, given)
        self._log_loss(index, report.world_from_camera is not None)
        self._log_tracking(report, pose_ms)

    def correct(self, report: PoseReport, corrections: Mapping[int, Pose | None]) -> None:
        """Log the trajectory with new poses of past frames, and the pose graph if it was optimised."""
        self._estimated.correct(corrections)
        whole = report.graph is not None or bool(corrections)
        if whole or self._n_logged % self._config.path_every == 0:
            self._log_trajectories(whole)
        self._n_logged += 1
        if report.graph is not None:
            self._log_graph(report.graph)

    def _log_loss(self, index: int, is_tracked: bool) -> None:
        if not is_tracked:
            if self._n_lost == 0:
                self._log.event(entities.EVENTS, f"the camera is lost from frame {index} on", "WARN")
            self._n_lost += 1
        elif self._n_lost:
            self._log.event(entities.EVENTS, f"the camera is found again after {self._n_lost} lost frames", "INFO")
            self._n_lost = 0

    def _log_tracking(self, report: PoseReport, pose_ms: float) -> None:
        log, quality = self._log, report.tracking
        log.scalars(entities.TRACKED, [float(report.world_from_camera is not None)])
        log.scalars(entities.TRACKING_MS, [pose_ms])
        if quality is None:
            for path in (entities.DEPTH_FOUND, entities.FEATURES_FOUND, entities.SIGMA):
                log.clear(path, recursive=False)
            return
        log.scalars(entities.DEPTH_FOUND, [quality.score, quality.agreement])
        log.scalars(entities.FEATURES_FOUND, [quality.n_features])
        log.scalars(entities.SIGMA, [1e3 * quality.sigma_rotation_rad, 1e3 * quality.sigma_shift_m])

    def _log_trajectories(self, whole: bool) -> None:
        self._log_trajectory(entities.ESTIMATED, self._estimated, np.eye(4), whole)
        if self._common is None:
            self._common = min(self._given.poses.keys() & self._estimated.poses.keys(), default=None)
        if self._common is not None:
            estimated_from_given = self._estimated.poses[self._common] @ inverse(self._given.poses[self._common])
            self._log_trajectory(entities.GIVEN, self._given, estimated_from_given, whole)

    def _log_trajectory(self, entity: str, lines: TrajectoryLines, world_from_lines: Float64Array, whole: bool) -> None:
        if whole:
            self._log.lines(f"{entity}/{WHOLE}", lines.whole(world_from_lines))
        self._log.lines(f"{entity}/{NEWEST}", lines.newest(world_from_lines))

    def _log_graph(self, graph: GraphReport) -> None:
        positions = graph.world_from_camera[:, :3, 3]
        self._log_move(graph.frames.tolist(), positions)
        self._log.dots(entities.KEYFRAMES, positions, KEYFRAME_COLOR, KEYFRAME_RADIUS_POINTS)
        ends = positions[graph.edges]
        self._log.lines(entities.ODOMETRY, ends[graph.is_odometry])
        self._log.lines(entities.CLOSURES, ends[~graph.is_odometry])
        self._log_uncertainty(graph)
        counts = [len(positions), len(ends), graph.n_loops, graph.n_unanchored]
        self._log.scalars(entities.GRAPH_SIZE, counts)

    def _log_move(self, frames: list[int], positions: Float64Array) -> None:
        """Keyframes before and after, where an optimisation moved them visibly; until the next optimisation."""
        moves = [(self._keyframes[f], p) for f, p in zip(frames, positions, strict=True) if f in self._keyframes]
        self._keyframes = dict(zip(frames, positions, strict=True))
        before, after = np.array(moves).reshape(-1, 2, 3).swapaxes(0, 1)
        moved_m = float(np.linalg.norm(after - before, axis=1).max(initial=0))
        if moved_m < self._config.shown_move_m:
            self._log.clear(entities.MOVE, recursive=True)
            return
        self._log.lines(entities.BEFORE, before[None])
        self._log.lines(entities.AFTER, after[None])
        self._log.event(entities.EVENTS, f"keyframes moved by up to {100 * moved_m:.1f} cm", "INFO")

    def _log_uncertainty(self, graph: GraphReport) -> None:
        """Each ellipsoid is as of when its covariance was last computed, at the keyframe's present pose."""
        self._covariances.update(graph.covariances)
        rows = [row for row, frame in enumerate(graph.frames.tolist()) if frame in self._covariances]
        if not rows:
            return
        covariances = np.array([self._covariances[int(graph.frames[row])] for row in rows])
        ellipsoids = position_ellipsoids(graph.world_from_camera[rows], covariances, self._config.ellipsoid_sigmas)
        self._log.ellipsoids(entities.UNCERTAINTY, ellipsoids, UNCERTAIN_COLOR)
