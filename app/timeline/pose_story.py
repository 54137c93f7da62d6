"""What the pose estimation did: where the camera was, by which keyframes and edges, how surely, where it got lost."""

from __future__ import annotations

import numpy as np

from app.frames.frame_packet import END, FramePacket
from app.timeline import entities
from app.timeline.camera_path import PathLines
from app.timeline.config import TimelineConfig
from app.timeline.ellipsoids import position_ellipsoids
from app.timeline.rerun_log import RerunLog
from razer.arrays import Float64Array
from razer.geometry import inverse
from slam.report import GraphReport, PoseReport

WHOLE, NEWEST = "whole", "newest"  # parts of a path: the second is what was added since the first was drawn
LINE_COLORS = {
    **{f"{entities.ESTIMATED}/{part}": (255, 160, 0) for part in (WHOLE, NEWEST)},
    **{f"{entities.GIVEN}/{part}": (40, 160, 60) for part in (WHOLE, NEWEST)},
    entities.ODOMETRY: (150, 150, 170),
    entities.CLOSURES: (200, 60, 200),
    entities.BEFORE: (214, 39, 40),
    entities.AFTER: (31, 111, 180),
}
EDGES = (entities.ODOMETRY, entities.CLOSURES)
PATH_RADIUS_POINTS, EDGE_RADIUS_POINTS = 1.5, 0.5  # there are many edges, and they lie on each other
KEYFRAME_COLOR, UNCERTAIN_COLOR = (255, 230, 60), (80, 200, 255)
KEYFRAME_RADIUS_POINTS = 2.5


class PoseStory:
    """Puts it onto the timeline, one index after the other; of the frame that is being logged."""

    def __init__(self, log: RerunLog, config: TimelineConfig) -> None:
        self._log = log
        self._config = config
        self._estimated, self._given = PathLines(), PathLines()
        self._common: int | None = None  # the first frame that has both an estimated and a given pose
        self._told = 0
        self._lost_for = 0
        self._keyframes: dict[int, Float64Array] = {}
        self._covariances: dict[int, Float64Array] = {}
        for entity, color in LINE_COLORS.items():
            log.line_style(entity, color, EDGE_RADIUS_POINTS if entity in EDGES else PATH_RADIUS_POINTS)
        log.name_series(entities.TRACKED, ["tracked"])
        log.name_series(entities.DEPTH_FOUND, ["score", "agreement"])
        log.name_series(entities.FEATURES_FOUND, ["features that agree"])
        log.name_series(entities.SIGMA, ["rotation, mrad", "shift, mm"])
        log.name_series(entities.GRAPH_SIZE, ["keyframes", "edges", "loops", "keyframes unanchored"])
        log.name_series(entities.TRACKING_MS, ["tracking, ms"])

    def tell(self, look: FramePacket, report: PoseReport) -> None:
        """What happened at an index, and at END when the estimation was finished."""
        if look.index != END:
            self._estimated.look(look.index, report.world_from_camera)
            self._given.look(look.index, look.given)
            self._tell_loss(look.index, report.world_from_camera is not None)
            self._log_tracking(report, look.stage_ms.get("pose", 0.0))
        self._estimated.move(look.corrections)
        whole = report.graph is not None or bool(look.corrections)
        if whole or self._told % self._config.path_every == 0:
            self._log_paths(whole)
        self._told += 1
        if report.graph is not None:
            self._log_graph(report.graph)

    def _tell_loss(self, index: int, tracked: bool) -> None:
        if not tracked:
            if self._lost_for == 0:
                self._log.event(entities.EVENTS, f"the camera is lost from frame {index} on", "WARN")
            self._lost_for += 1
        elif self._lost_for:
            self._log.event(entities.EVENTS, f"the camera is found again after {self._lost_for} lost frames", "INFO")
            self._lost_for = 0

    def _log_tracking(self, report: PoseReport, pose_ms: float) -> None:
        log, found = self._log, report.tracking
        log.scalars(entities.TRACKED, [float(report.world_from_camera is not None)])
        log.scalars(entities.TRACKING_MS, [pose_ms])
        if found is None:
            for path in (entities.DEPTH_FOUND, entities.FEATURES_FOUND, entities.SIGMA):
                log.clear(path, recursive=False)
            return
        log.scalars(entities.DEPTH_FOUND, [found.score, found.agreement])
        log.scalars(entities.FEATURES_FOUND, [found.n_features])
        log.scalars(entities.SIGMA, [1e3 * found.sigma_rotation_rad, 1e3 * found.sigma_shift_m])

    def _log_paths(self, whole: bool) -> None:
        self._log_path(entities.ESTIMATED, self._estimated, np.eye(4), whole)
        if self._common is None:
            self._common = min(self._given.poses.keys() & self._estimated.poses.keys(), default=None)
        if self._common is not None:
            estimated_from_given = self._estimated.poses[self._common] @ inverse(self._given.poses[self._common])
            self._log_path(entities.GIVEN, self._given, estimated_from_given, whole)

    def _log_path(self, entity: str, path: PathLines, world_from_path: Float64Array, whole: bool) -> None:
        if whole:
            self._log.lines(f"{entity}/{WHOLE}", path.whole(world_from_path))
        self._log.lines(f"{entity}/{NEWEST}", path.newest(world_from_path))

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
        known = [(self._keyframes[f], p) for f, p in zip(frames, positions, strict=True) if f in self._keyframes]
        self._keyframes = dict(zip(frames, positions, strict=True))
        before, after = np.array(known).reshape(-1, 2, 3).swapaxes(0, 1)
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
        found = position_ellipsoids(graph.world_from_camera[rows], covariances, self._config.ellipsoid_sigmas)
        self._log.ellipsoids(entities.UNCERTAINTY, found, UNCERTAIN_COLOR)
