"""The timeline of a run as a Rerun recording: images, the growing map, what became of each object, poses, and time."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import cv2
import numpy as np

from app.profiling.memory import rss_mb
from app.render.mesh_decimation import decimated
from app.render.palette import instance_colors
from app.render.viewpoint import Viewpoint, behind
from app.stored_state.written_log import WrittenLog
from app.timeline.config import TimelineConfig
from app.timeline.entities import (
    BOXES,
    CAMERA,
    COLOR,
    DECISIONS,
    DEPTH,
    EVENTS,
    GROWING,
    INSTANCE_IMAGE,
    INSTANCES,
    LABELS,
    OBJECTS,
    PATH,
    POSE_SUMMARY,
    RECENT_PATH,
    SUMMARY,
    SURFACE,
)  # fmt: skip
from app.timeline.growing_map import GrowingMap
from app.timeline.images import depth_png, every_nth, instance_overlay, jpeg, resized, scaled_to, subsampling_step
from app.timeline.objects.decision_words import decision_table
from app.timeline.objects.lives_document import item_label, pair_verdict
from app.timeline.objects.object_history import ObjectHistory, entity_names
from app.timeline.objects.object_log import log_labels, log_objects
from app.timeline.performance_log import PerformanceLog
from app.timeline.poses.map_eyes import map_eyes
from app.timeline.poses.pose_estimation_log import PoseEstimationLog
from app.timeline.recording.layout import RunView, run_layout
from app.timeline.recording.rerun_log import RerunLog
from app.timeline.summary import RunSummary
from app.timeline.surface_colors import lightly_tinted
from razer.arrays import Float64Array, Pose
from razer.boxes.oriented_box import OrientedBox
from razer.frame import Frame, Intrinsics
from razer.map_object import MapObject
from razer.mapper import Mapper
from razer.panoptic_map import PanopticMap
from razer.tracking.step_result import StepResult
from razer.tracking.track import Track
from slam.report import PoseReport

NEAREST = cv2.INTER_NEAREST  # ids do not mix
PATH_COLOR = (255, 140, 0)
RECENT_FRAMES = 60
MAX_LABELS = 15
MAP_PX = 600  # height of the map in a window of usual size; less where two runs are shown
_REMEMBERED = (
    "_pose_log", "_history", "_growing", "_performance", "_summary", "_n_shown", "_last_index", "_last_images",
    "_poses",
)  # fmt: skip


class Timeline:
    """Writes the recording `path` frame by frame; `close` it when the run ends, whatever happened."""

    def __init__(
        self,
        path: Path,
        intrinsics: Intrinsics,
        config: TimelineConfig,
        *,
        live: bool = False,
        written: WrittenLog | None = None,
    ) -> None:
        """A new recording, or one that goes on from what was `written` of it when its run was cut off."""
        self.settings = config
        self._log = RerunLog(path, live=live, written=written)
        self._pose_log: PoseEstimationLog | None = None
        self._history = ObjectHistory()
        self._growing = GrowingMap(self._log, config)
        self._performance = PerformanceLog(self._log)
        self._summary = RunSummary()
        self._n_shown = 0
        self._last_index = 0
        self._last_images: dict[str, bytes] = {}
        self._poses: list[Float64Array] = []
        self._raster_step = subsampling_step(intrinsics, config.raster_max_edge)
        self._color_camera = scaled_to(intrinsics, config.image_max_edge)
        for entity in (COLOR, INSTANCE_IMAGE):
            self._log.camera(entity, self._color_camera)
        self._log.camera(DEPTH, every_nth(intrinsics, self._raster_step))
        self._log.series(INSTANCES, ["all live", "confirmed"], [(160, 160, 160), (31, 119, 180)])
        self._log.line_style(RECENT_PATH, PATH_COLOR, 2.0)

    @property
    def log(self) -> RerunLog:
        """What it writes to."""
        return self._log

    @property
    def state(self) -> dict[str, Any]:
        """All that it remembers of the frames so far."""
        return {name: getattr(self, name) for name in _REMEMBERED}

    @state.setter
    def state(self, state: Mapping[str, Any]) -> None:
        for name in _REMEMBERED:
            setattr(self, name, state[name])

    def written(self) -> WrittenLog | None:
        """What of it is in the file, once all that was logged is; None where it cannot be written."""
        return self._log.written(self.settings.close_timeout_s)

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
            self._lay_out([behind(frame.pose)] * 3)
        confirmed = [track for track in mapper.tracks if track.confirmed]
        self._poses.append(frame.pose)
        self._summary.use(frame.pose[:3, 3])
        self._log_camera(frame.pose)
        self._log_images(frame, step, confirmed)
        self._log_map(step, mapper, confirmed)
        self._log_events(frame, step, mapper)
        self._log.scalars(INSTANCES, [len(mapper.tracks), len(confirmed)])
        self._performance.add(frame.index, stage_ms, rss_mb(), mapper.voxels.memory_bytes / 1e6)
        self._n_shown += 1

    def track(
        self,
        frame_index: int,
        report: PoseReport | None,
        *,
        corrections: Mapping[int, Pose | None],
        given: Pose | None = None,
    ) -> None:
        """Log how a frame was located, before anything else of that frame.

        Args:
            frame_index: of the frame.
            report: what the estimation did; None where poses are given: nothing is logged.
            corrections: new world_from_camera (4, 4) of frames before it, by frame index, None = not known after all.
            given: the pose (4, 4) that the frame itself came with.
        """
        if report is None:
            return
        self._start_frame(frame_index)
        if self._pose_log is None:
            self._pose_log = PoseEstimationLog(self._log, self.settings)
        self._pose_log.add_frame(frame_index, report, given)
        self._pose_log.correct(report, corrections)

    def finish_tracking(self, report: PoseReport | None, corrections: Mapping[int, Pose | None]) -> None:
        """Log the last corrections, after the last frame; nothing where poses are given."""
        if report is None or self._pose_log is None:
            return
        self._log.start_frame(self._last_index + 1)
        with self._log.in_front():
            self._pose_log.correct(report, corrections)

    def skipped(self, frame_index: int, reason: str) -> None:
        """Log that a frame was not used, and why."""
        self._start_frame(frame_index)
        self._summary.leave_out(frame_index, reason)
        self._performance.leave_out()
        self._log.event(EVENTS, f"skipped frame {frame_index}: {reason}", "WARN")

    def finish(self, panoptic: PanopticMap) -> None:
        """Log the finished map in place of the growing one, where a viewer reads it first."""
        self._start_frame(self._last_index + 1)
        mesh = decimated(panoptic.mesh, self.settings.mesh_max_vertices)
        with self._log.in_front():
            eyes = [behind(self._poses[-1] if self._poses else np.eye(4))] * 3
            if len(mesh.vertices):
                stuff = frozenset(item.id for item in panoptic.objects if item.is_stuff)
                names = entity_names({item.id: item.class_name for item in panoptic.objects if item.is_stuff})
                hidden = tuple(f"{OBJECTS}/{name}" for name in names.values())
                eyes = map_eyes(mesh, stuff, np.array(self._poses), panoptic.up)
                self._lay_out(eyes, hidden)
                self._log.clear(GROWING, recursive=True)
                self._log.mesh(SURFACE, mesh, lightly_tinted(mesh, stuff))
            self._log_finished(panoptic, eyes)

    def _log_finished(self, panoptic: PanopticMap, eyes: Sequence[Viewpoint]) -> None:
        things = [item for item in panoptic.objects if not item.is_stuff]
        self._log_boxes(things, {item.id: item.box for item in things})
        log_labels(self._log, LABELS, sorted(things, key=_importance), eyes[0], MAP_PX)
        self._performance.finish()
        poses = self._pose_verdict()
        verdicts = [*poses[:2], *pair_verdict(things)]
        card = self._summary.markdown(len(things), len(panoptic.objects) - len(things), verdicts)
        self._log.document(SUMMARY, card)
        self._log.document(POSE_SUMMARY, "\n\n".join(self._summary.gaps() + poses))
        for entity, image in self._last_images.items():
            self._log.jpeg(entity, image)
        if self._poses:
            self._log_camera(self._poses[-1])
        if self._pose_log is not None:
            self._pose_log.settle()
        elif self._poses:  # it shows estimated poses as they were corrected
            self._log.line_style(PATH, PATH_COLOR)
            self._log.lines(PATH, [np.array(self._poses)[:, :3, 3]])
        log_objects(self._log, panoptic, self._history.lives, self._growing.drawn(), eyes[2])

    def _pose_verdict(self) -> list[str]:
        if self._pose_log is None:
            return ["The poses are those that came with the recording."]
        self._summary.find_late(self._pose_log.located)
        return self._pose_log.verdict()

    def close(self, *, join: bool = True, keep_parts: bool = False) -> None:
        """Write out what is still pending, for `close_timeout_s` at most, `join` the parts of the file, and remove them
        unless the run may still have to be gone on with; more calls do nothing."""
        self._log.close(self.settings.close_timeout_s, join=join, keep_parts=keep_parts)

    def _lay_out(self, eyes: Sequence[Viewpoint], hidden: tuple[str, ...] = ()) -> None:
        (eye, top, objects_eye), estimated = eyes, self._pose_log is not None
        self._log.show(run_layout(RunView(eye, top, objects_eye, estimated, self._performance.clipped_ms, hidden)))

    def _due(self, every: int) -> bool:
        return self._n_shown % every == 0

    def _start_frame(self, index: int) -> None:
        self._last_index = index
        self._log.start_frame(index)

    def _log_camera(self, pose: Pose) -> None:
        self._log.pose(CAMERA, pose)
        recent = np.array(self._poses[-RECENT_FRAMES:])[:, :3, 3]
        self._log.lines(RECENT_PATH, [recent] if len(recent) > 1 else [])

    def _log_images(self, frame: Frame, step: StepResult, confirmed: Sequence[Track]) -> None:
        config, n, camera = self.settings, self._raster_step, self._color_camera
        if self._due(config.depth_every):
            self._log.depth_png(DEPTH, depth_png(frame.depth[::n, ::n]), frame.stamp)
        due = [entity for entity, every in ((COLOR, config.image_every), (INSTANCE_IMAGE, config.ids_every))
               if self._due(every)]  # fmt: skip
        if not due:
            return
        images = {COLOR: resized(frame.rgb, camera)}
        if INSTANCE_IMAGE in due:
            ids = resized(step.id_image.astype(np.uint16), camera, NEAREST).astype(np.int32)
            names = {track.id: item_label(track) for track in confirmed}
            images[INSTANCE_IMAGE] = instance_overlay(images[COLOR], ids, names)
        for entity in due:
            self._last_images[entity] = jpeg(images[entity], config.jpeg_quality)
            self._log.jpeg(entity, self._last_images[entity])

    def _log_map(self, step: StepResult, mapper: Mapper, confirmed: Sequence[Track]) -> None:
        if step.rebuilt:
            self._log.event(EVENTS, "the map was rebuilt at corrected poses", "INFO")
        self._growing.observe(step.changed_blocks, rebuilt=step.rebuilt)
        if not step.rebuilt and not self._due(self.settings.surface_every):
            return
        self._growing.draw(mapper.voxels)
        things = [track for track in confirmed if not track.is_stuff]
        self._log_boxes(things, self._growing.seen_boxes(things))
        self._log.document(SUMMARY, self._summary.markdown(len(things), len(confirmed) - len(things)))

    def _log_boxes(self, things: Sequence[Track | MapObject], boxes: Mapping[int, OrientedBox]) -> None:
        """Boxes without names, and names of the largest, of those that have one first."""
        shown = [item for item in things if item.id in boxes]
        if not shown:
            for entity in (BOXES, LABELS):
                self._log.clear(entity, recursive=False)
            return
        colors = instance_colors(np.array([item.id for item in shown]))
        self._log.boxes(BOXES, [boxes[item.id] for item in shown], colors)
        shown.sort(key=_importance)
        named = shown[:MAX_LABELS]
        middles = np.array([boxes[item.id].center for item in named])
        self._log.labels(LABELS, middles, [item_label(item) for item in named])

    def _log_events(self, frame: Frame, step: StepResult, mapper: Mapper) -> None:
        for event in self._history.add(frame, step, mapper.tracks):
            self._log.event(EVENTS, event.text, "INFO")
        if self.settings.decisions:
            self._log.document(DECISIONS, decision_table(step))


def _importance(item: Track | MapObject) -> tuple[bool, int]:
    """What is to be named first sorts first: the largest of those that have a name."""
    return item.class_name is None, -item.n_voxels
