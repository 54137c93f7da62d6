"""The timeline of a run as a Rerun recording: images, boxes, events, association decisions, the growing map."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path

import numpy as np

from app.profiling.memory import rss_mb
from app.render.mesh_decimation import decimated
from app.render.palette import instance_colors, tinted
from app.render.viewpoint import Viewpoint, behind, overview
from app.timeline.config import TimelineConfig
from app.timeline.entities import (
    BOXES,
    CAMERA,
    COLOR,
    DECISIONS,
    DEPTH,
    EVENTS,
    IDS,
    INSTANCES,
    MEMORY,
    MESH,
    PATH,
    POINTS,
    STAGES,
    WORLD,
)
from app.timeline.event_log import decision_table, step_events
from app.timeline.images import depth_png, every_nth, jpeg, scaled_to, subsampling_step
from app.timeline.map_chunks import ChunkSchedule, by_chunk, thinned
from app.timeline.pose_estimation_log import PoseEstimationLog
from app.timeline.rerun_log import RerunLog, run_layout
from razer.arrays import Float64Array, Pose
from razer.frame import Frame, Intrinsics
from razer.map_object import MapObject
from razer.mapper import Mapper
from razer.panoptic_map import PanopticMap
from razer.tracking.step_result import StepResult
from razer.tracking.track import Track
from razer.volume.mesh_extraction import extract_points
from slam.report import PoseReport

PATH_COLOR = (255, 160, 0)
MAX_IDS = 2**16  # what an id image can hold
NAMED_IDS = 1024  # colours of ids are announced in batches of so many


class Timeline:
    """Writes the recording `path` frame by frame; `close` it when the run ends, whatever happened."""

    def __init__(self, path: Path, intrinsics: Intrinsics, config: TimelineConfig) -> None:
        self._config = config
        self._log = RerunLog(path)
        self._pose_log: PoseEstimationLog | None = None
        self._n_shown = 0
        self._last_index = 0
        self._named_ids = 0
        self._stage_names: list[str] = []
        self._schedule = ChunkSchedule(config.points_growth)
        self._poses: list[Float64Array] = []
        self._raster_step = subsampling_step(intrinsics, config.raster_max_edge)
        self._color_camera = scaled_to(intrinsics, config.image_max_edge)
        self._log_cameras(every_nth(intrinsics, self._raster_step))
        self._log.name_series(INSTANCES, ["confirmed", "all live"])
        self._log.name_series(MEMORY, ["process MB", "voxels MB"])

    def _log_cameras(self, raster_camera: Intrinsics) -> None:
        for entity, camera in ((COLOR, self._color_camera), (DEPTH, raster_camera), (IDS, raster_camera)):
            self._log.camera(entity, camera)

    def show(self, frame: Frame, step: StepResult, mapper: Mapper, stage_ms: Mapping[str, float]) -> None:
        """Log one mapped frame.

        Args:
            frame: posed.
            step: what mapping it did.
            mapper: the map after it.
            stage_ms: milliseconds that its stages took so far.
        """
        self._start_frame(frame.index)
        if self._n_shown == 0:
            self._lay_out(behind(frame.pose))
        self._log_images(frame, step)
        self._log_boxes(mapper)
        self._log_events(step)
        self._log_scalars(mapper, stage_ms)
        self._schedule.observe(step.changed_blocks)
        if step.rebuilt:
            self._log.event(EVENTS, "the map was rebuilt at corrected poses", "INFO")
            self._schedule.invalidate()
        if step.rebuilt or self._due(self._config.points_every):
            self._log_points(mapper)
        self._poses.append(frame.pose)
        self._n_shown += 1

    def track(
        self,
        frame_index: int,
        report: PoseReport | None,
        *,
        corrections: Mapping[int, Pose | None],
        given: Pose | None = None,
        pose_ms: float = 0.0,
    ) -> None:
        """Log how a frame was located, before anything else of that frame.

        Args:
            frame_index: of the frame.
            report: what the estimation did; None where poses are given: nothing is logged.
            corrections: new world_from_camera (4, 4) of frames before it, by frame index, None = not known after all.
            given: the pose (4, 4) that the frame itself came with.
            pose_ms: milliseconds that the estimation took.
        """
        if report is None:
            return
        self._start_frame(frame_index)
        if self._pose_log is None:
            self._pose_log = PoseEstimationLog(self._log, self._config)
        self._pose_log.add_frame(frame_index, report, given, pose_ms)
        self._pose_log.correct(report, corrections)

    def finish_tracking(self, report: PoseReport | None, corrections: Mapping[int, Pose | None]) -> None:
        """Log the last corrections, after the last frame; nothing where poses are given."""
        if report is None or self._pose_log is None:
            return
        self._log.start_frame(self._last_index + 1)
        self._pose_log.correct(report, corrections)

    def skipped(self, frame_index: int, reason: str) -> None:
        """Log that a frame was not used, and why."""
        self._start_frame(frame_index)
        self._log.event(EVENTS, f"skipped frame {frame_index}: {reason}", "WARN")

    def finish(self, panoptic: PanopticMap) -> None:
        """Log the finished map in place of the points, and open the recording on an overview of it."""
        self._start_frame(self._last_index + 1)
        self._log_instances(panoptic.objects)
        mesh = decimated(panoptic.mesh, self._config.mesh_max_vertices)
        if not len(mesh.vertices):
            return
        self._log.clear(POINTS, recursive=True)
        self._log.mesh(MESH, mesh, tinted(mesh.colors, mesh.instances))
        poses = np.array(self._poses)
        if self._pose_log is None:  # it shows estimated poses as they were corrected
            self._log.line_style(PATH, PATH_COLOR)
            self._log.lines(PATH, [poses[:, :3, 3]])
        up, forward = -poses[:, :3, 1].mean(axis=0), poses[:, :3, 2].mean(axis=0)
        self._lay_out(overview(mesh.vertices.astype(np.float64), up, forward))

    def close(self) -> None:
        """Write out what is still pending, for `close_timeout_s` at most; more calls do nothing."""
        self._log.close(self._config.close_timeout_s)

    def _lay_out(self, view: Viewpoint) -> None:
        self._log.show(run_layout(view, poses_estimated=self._pose_log is not None))

    def _due(self, every: int) -> bool:
        return self._n_shown % every == 0

    def _start_frame(self, index: int) -> None:
        self._last_index = index
        self._log.start_frame(index)

    def _log_images(self, frame: Frame, step: StepResult) -> None:
        config, n = self._config, self._raster_step
        self._log.pose(CAMERA, frame.pose)
        if self._due(config.image_every):
            self._log.jpeg(COLOR, jpeg(frame.rgb, self._color_camera, config.jpeg_quality))
        if self._due(config.depth_every):
            self._log.depth_png(DEPTH, depth_png(frame.depth[::n, ::n]))
        if self._due(config.ids_every):
            self._name_ids(int(step.id_image.max(initial=0)))
            self._log.ids(IDS, step.id_image[::n, ::n].astype(np.uint16))

    def _name_ids(self, highest: int) -> None:
        """Give ids their colours before they are first seen in an id image."""
        if highest < self._named_ids or self._named_ids == MAX_IDS:
            return
        self._named_ids = min((highest // NAMED_IDS + 1) * NAMED_IDS, MAX_IDS)
        self._log.name_ids(WORLD, instance_colors(np.arange(self._named_ids)))

    def _log_boxes(self, mapper: Mapper) -> None:
        if not self._due(self._config.boxes_every):
            return
        self._log_instances([track for track in mapper.tracks if track.confirmed])

    def _log_instances(self, instances: Sequence[Track | MapObject]) -> None:
        if not instances:
            self._log.clear(BOXES, recursive=False)
            return
        colors = instance_colors(np.array([item.id for item in instances]))
        labels = [f"#{item.id} {item.class_name or ''}".rstrip() for item in instances]
        self._log.boxes(BOXES, [item.box for item in instances], colors, labels)

    def _log_events(self, step: StepResult) -> None:
        for event in step_events(step):
            self._log.event(EVENTS, event.text, event.level)
        if self._config.decisions:
            self._log.document(DECISIONS, decision_table(step))

    def _log_scalars(self, mapper: Mapper, stage_ms: Mapping[str, float]) -> None:
        if new_names := [name for name in stage_ms if name not in self._stage_names]:
            self._stage_names += new_names
            self._log.name_series(STAGES, self._stage_names)
        self._log.scalars(STAGES, [stage_ms.get(name, 0.0) for name in self._stage_names])
        confirmed = sum(track.confirmed for track in mapper.tracks)
        self._log.scalars(INSTANCES, [confirmed, len(mapper.tracks)])
        self._log.scalars(MEMORY, [rss_mb(), mapper.voxels.memory_bytes / 1e6])

    def _log_points(self, mapper: Mapper) -> None:
        due = self._schedule.take_due()
        if not due:
            return
        size_m = mapper.voxels.settings.voxel_size_m
        surface = extract_points(mapper.voxels, np.concatenate([chunk.block_keys for chunk in due]))
        points = thinned(surface, size_m, self._config.points_thinning)
        colors = instance_colors(points.instances)
        rows_by_chunk = by_chunk(points, size_m)
        for chunk in due:
            rows = rows_by_chunk.get(chunk, np.zeros(0, np.int64))  # what has been carved away must vanish here too
            entity = f"{POINTS}/{chunk.x}_{chunk.y}_{chunk.z}"
            self._log.points(entity, points.positions[rows], colors[rows], 0.75 * size_m)
