"""Pose estimation on the timeline: trajectory, keyframes, pose graph, uncertainty, and where tracking was lost."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from app.timeline import entities
from app.timeline.config import TimelineConfig
from app.timeline.poses.pose_verdict import pose_verdict
from app.timeline.poses.trajectory_lines import TrajectoryLines, dashed
from app.timeline.recording.ellipsoids import position_ellipsoids
from app.timeline.recording.rerun_log import RerunLog
from razer.arrays import Float64Array, Pose
from razer.geometry import inverse
from slam.report import GraphReport, PoseReport, TrackingQuality

WHOLE, NEWEST = "whole", "newest"  # parts of a trajectory: the second is what was added since the first was drawn
ORANGE, GREY, RED, GREEN = (255, 140, 0), (130, 130, 130), (220, 20, 30), (40, 160, 60)
LINE_COLORS = {
    **{f"{entities.ESTIMATED}/{part}": ORANGE for part in (WHOLE, NEWEST)},
    **{f"{entities.GIVEN}/{part}": GREY for part in (WHOLE, NEWEST)},
    entities.ODOMETRY: (190, 190, 205),
    entities.CLOSURES: (200, 60, 200),
    entities.NEWEST_CLOSURES: (255, 0, 255),
    entities.CORRECTION: RED,
}
EDGES = (entities.ODOMETRY, entities.CLOSURES)
SERIES = {
    entities.TRACKED: ["tracked"],
    entities.DEPTH_FOUND: ["score", "agreement"],
    entities.FEATURES_FOUND: ["features that agree"],
    entities.GRAPH_SIZE: ["keyframes", "edges", "loops", "keyframes unanchored"],
}
PATH_RADIUS_POINTS, EDGE_RADIUS_POINTS = 1.8, 0.5  # there are many edges, and they lie on each other
KEYFRAME_COLOR, UNCERTAIN_COLOR = (120, 120, 160), (80, 200, 255)
KEYFRAME_RADIUS_POINTS, EVENT_RADIUS_POINTS = 1.5, 6.0
FEW_FEATURES = 30  # that agree; with fewer a registration is hardly trusted


class PoseEstimationLog:
    """Logs it frame by frame, each at the frame that `log` is at."""

    def __init__(self, log: RerunLog, config: TimelineConfig) -> None:
        self._log = log
        self._config = config
        self._estimated, self._given = TrajectoryLines(), TrajectoryLines()
        self._common: int | None = None  # the first frame that has both an estimated and a given pose
        self._n_logged = 0
        self._n_frames = 0
        self._n_loops = 0
        self._n_lost = 0
        self._quality: TrackingQuality | None = None  # of the last frame that was tracked
        self._last_tracked: int | None = None
        self._lost_at: list[int] = []  # the last frames before the camera was lost
        self._found_at: list[int] = []
        self._closures: set[tuple[int, int]] = set()
        self._keyframes: dict[int, Float64Array] = {}
        self._covariances: dict[int, Float64Array] = {}
        for entity, color in LINE_COLORS.items():
            log.line_style(entity, color, EDGE_RADIUS_POINTS if entity in EDGES else PATH_RADIUS_POINTS)
        for entity, names in SERIES.items():
            log.series(entity, names)
        log.series(entities.SIGMA, ["uncertainty, cm"], [ORANGE])
        log.marks(entities.CLOSURE_MARKS, "loop closed", LINE_COLORS[entities.NEWEST_CLOSURES], "Diamond")
        log.marks(entities.LOST_MARKS, "lost", RED, "Cross")

    def add_frame(self, index: int, report: PoseReport, given: Pose | None) -> None:
        """Log how a further frame was tracked.

        Args:
            index: of the frame.
            report: what was estimated of it.
            given: the pose (4, 4) that the frame itself came with.
        """
        self._n_frames += 1
        self._estimated.add(index, report.world_from_camera)
        self._given.add(index, given)
        self._log_loss(index, report)
        self._log_tracking(report)

    def correct(self, report: PoseReport, corrections: Mapping[int, Pose | None]) -> None:
        """Log the trajectory with new poses of past frames, and the pose graph if it was optimised."""
        self._estimated.correct(corrections)
        whole = report.graph is not None or bool(corrections)
        if whole or self._n_logged % self._config.path_every == 0:
            self._log_trajectories(whole)
        if whole and self._lost_at:
            self._log_places()
        self._n_logged += 1
        if report.graph is not None:
            self._log_graph(report.graph)

    @property
    def located(self) -> frozenset[int]:
        """The frames whose poses are known by now."""
        return frozenset(self._estimated.poses)

    def verdict(self) -> list[str]:
        """Lines of Markdown: how well it went, as known by now."""
        return pose_verdict(self._estimated.poses, self._given.poses, self._n_frames, self._n_loops)

    def settle(self) -> None:
        """The run is over: nothing is new any more."""
        for entity in (entities.NEWEST_CLOSURES, entities.CORRECTION):
            self._log.clear(entity, recursive=False)

    def _log_loss(self, index: int, report: PoseReport) -> None:
        if report.world_from_camera is None:
            self._log.scalars(entities.LOST_MARKS, [0.0])
            if self._n_lost == 0:
                self._log.event(
                    entities.POSE_EVENTS, f"the camera is lost from frame {index} on: {self._why()}", "WARN"
                )
                self._lost_at += [] if self._last_tracked is None else [self._last_tracked]
            self._n_lost += 1
            return
        if self._n_lost:
            seen = "" if report.tracking is None else f": {report.tracking.n_features} features agree"
            text = f"the camera is found again in frame {index} after {self._n_lost} lost frames{seen}"
            self._log.event(entities.POSE_EVENTS, text, "INFO")
            self._found_at.append(index)
            self._n_lost = 0
        self._last_tracked = index
        self._quality = report.tracking or self._quality

    def _why(self) -> str:
        """What the last registration before it was like: a loss mostly announces itself."""
        if self._quality is None:
            return "no view was registered yet"
        if self._quality.n_features < FEW_FEATURES:
            return f"too little to hold on to, only {self._quality.n_features} features agreed in the frame before"
        return (
            f"its view fits none that is known, though {self._quality.n_features} features agreed in the frame before "
            "(covered, blurred, or turned away too fast)"
        )

    def _log_tracking(self, report: PoseReport) -> None:
        log, quality = self._log, report.tracking
        log.scalars(entities.TRACKED, [float(report.world_from_camera is not None)])
        if quality is None:
            for path in (entities.DEPTH_FOUND, entities.FEATURES_FOUND, entities.SIGMA):
                log.clear(path, recursive=False)
            return
        log.scalars(entities.DEPTH_FOUND, [quality.score, quality.agreement])
        log.scalars(entities.FEATURES_FOUND, [quality.n_features])
        log.scalars(entities.SIGMA, [100 * quality.sigma_shift_m])

    def _log_places(self) -> None:
        """Where the camera was lost and found, as known now."""
        poses = self._estimated.poses
        for entity, frames, color, word in (
            (entities.LOST, self._lost_at, RED, "lost after"),
            (entities.FOUND, self._found_at, GREEN, "found in"),
        ):
            known = [frame for frame in frames if frame in poses]
            positions = np.array([poses[frame][:3, 3] for frame in known]).reshape(-1, 3)
            self._log.dots(entity, positions, color, EVENT_RADIUS_POINTS, [f"{word} frame {f}" for f in known])

    def _log_trajectories(self, whole: bool) -> None:
        self._log_trajectory(entities.ESTIMATED, self._estimated, np.eye(4), whole)
        if self._common not in self._estimated.poses:  # a correction may take a pose away again
            self._common = min(self._given.poses.keys() & self._estimated.poses.keys(), default=None)
        if self._common is not None:
            estimated_from_given = self._estimated.poses[self._common] @ inverse(self._given.poses[self._common])
            self._log_trajectory(entities.GIVEN, self._given, estimated_from_given, whole)

    def _log_trajectory(self, entity: str, lines: TrajectoryLines, world_from_lines: Float64Array, whole: bool) -> None:
        style = dashed if entity == entities.GIVEN else list
        if whole:
            self._log.lines(f"{entity}/{WHOLE}", style(lines.whole(world_from_lines)))
        self._log.lines(f"{entity}/{NEWEST}", style(lines.newest(world_from_lines)))

    def _log_graph(self, graph: GraphReport) -> None:
        positions = graph.world_from_camera[:, :3, 3]
        self._log_correction(graph.frames.tolist(), positions)
        self._log.dots(entities.KEYFRAMES, positions, KEYFRAME_COLOR, KEYFRAME_RADIUS_POINTS)
        ends = positions[graph.edges]
        self._log.lines(entities.ODOMETRY, ends[graph.is_odometry])
        self._log.lines(entities.CLOSURES, ends[~graph.is_odometry])
        self._log_new_closures(graph, ends)
        self._log_uncertainty(graph)
        self._n_loops = graph.n_loops
        counts = [len(positions), len(ends), graph.n_loops, graph.n_unanchored]
        self._log.scalars(entities.GRAPH_SIZE, counts)

    def _log_new_closures(self, graph: GraphReport, ends: Float64Array) -> None:
        """Those that came with this optimisation; they shine until the next."""
        frames = [tuple(pair) for pair in np.sort(graph.frames[graph.edges], axis=1).tolist()]
        new = [n for n, pair in enumerate(frames) if not graph.is_odometry[n] and pair not in self._closures]
        self._closures.update(frames[n] for n in new)
        self._log.lines(entities.NEWEST_CLOSURES, ends[new])
        if not new:
            return
        pairs = ", ".join("frame {1} shows what frame {0} did".format(*frames[n]) for n in new[:2])
        more = f", and {len(new) - 2} more" if len(new) > 2 else ""
        self._log.event(entities.POSE_EVENTS, f"loop closed: {pairs}{more}", "INFO")
        sigma_cm = 100 * self._quality.sigma_shift_m if self._quality is not None else 0.0
        self._log.scalars(entities.CLOSURE_MARKS, [sigma_cm])

    def _log_correction(self, frames: list[int], positions: Float64Array) -> None:
        """How an optimisation moved keyframes, where it shows; until the next one."""
        moves = [(self._keyframes[f], p) for f, p in zip(frames, positions, strict=True) if f in self._keyframes]
        self._keyframes = dict(zip(frames, positions, strict=True))
        lines = np.array(moves).reshape(-1, 2, 3)
        moved_m = float(np.linalg.norm(lines[:, 1] - lines[:, 0], axis=1).max(initial=0))
        if moved_m < self._config.shown_move_m:
            self._log.clear(entities.CORRECTION, recursive=False)
            return
        self._log.lines(entities.CORRECTION, lines)
        self._log.event(entities.POSE_EVENTS, f"keyframes moved by up to {100 * moved_m:.1f} cm", "INFO")

    def _log_uncertainty(self, graph: GraphReport) -> None:
        """Each ellipsoid is as of when its covariance was last computed, at the keyframe's present pose."""
        self._covariances.update(graph.covariances)
        rows = [row for row, frame in enumerate(graph.frames.tolist()) if frame in self._covariances]
        if not rows:
            return
        covariances = np.array([self._covariances[int(graph.frames[row])] for row in rows])
        ellipsoids = position_ellipsoids(graph.world_from_camera[rows], covariances, self._config.ellipsoid_sigmas)
        self._log.ellipsoids(entities.ELLIPSOIDS, ellipsoids, UNCERTAIN_COLOR)
