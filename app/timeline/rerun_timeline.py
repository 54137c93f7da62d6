"""The timeline of a run, one Rerun recording: what the camera saw, what the method decided, how the map grew.

Logging hands data to Rerun's own thread, which writes the file; only `close` waits for it, and not for ever.
"""

from __future__ import annotations

import warnings
from collections.abc import Mapping
from pathlib import Path

import numpy as np
import rerun as rr
import rerun.blueprint as rrb
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from app.palette import instance_colors, tinted
from app.running.memory import rss_mb
from app.timeline.config import TimelineConfig
from app.timeline.frame_story import decision_table, events
from app.timeline.images import at_most, depth_png, every_nth, jpeg, step_to
from app.timeline.map_chunks import ChunkSchedule, by_chunk, thinned
from app.timeline.mesh_limit import limited
from app.timeline.viewpoint import Viewpoint, behind, overview
from razer.frame import Frame, Intrinsics
from razer.mapper import Mapper
from razer.panoptic_map import PanopticMap
from razer.step import Step
from razer.surface import extract_points

FRAME = "frame"  # the timeline's one clock: the index of the frame

WORLD = "world"  # metres, right-handed
CAMERA = "world/camera"
COLOR = "world/camera/color"
DEPTH = "world/camera/depth"
IDS = "world/camera/ids"
BOXES = "world/map/boxes"
POINTS = "world/map/points"
MESH = "world/map/mesh"
PATH = "world/path"
EVENTS = "events"
DECISIONS = "decisions"
STAGES = "plots/ms"
INSTANCES = "plots/instances"
MEMORY = "plots/memory"

LOG_COLUMNS = rrb.TextLogColumns(text_log_columns=["LogLevel", "Body"])
PATH_COLOR = (255, 160, 0)
MAX_IDS = 2**16  # what an id image can hold
NAMED_IDS = 1024  # colours of ids are announced in batches of so many
# Larger chunks than Rerun's own: a browser opens the recording many times faster.
BATCHES = rr.ChunkBatcherConfig(flush_tick=10, flush_num_bytes=4 * 2**20)


class Timeline:
    """Writes the recording `path` frame by frame; `close` it when the run ends, whatever happened."""

    def __init__(self, path: Path, intrinsics: Intrinsics, config: TimelineConfig) -> None:
        self._config = config
        self._stream = rr.RecordingStream("razer", batcher_config=BATCHES)
        self._stream.set_log_tick_enabled(False)
        self._stream.set_log_time_enabled(False)
        self._stream.save(path)
        self._open = True
        self._shown = 0
        self._last_index = 0
        self._named_ids = 0
        self._stage_names: list[str] = []
        self._schedule = ChunkSchedule(config.points_growth)
        self._poses: list[NDArray[np.float64]] = []
        self._raster_step = step_to(intrinsics, config.raster_max_edge)
        self._color_camera = at_most(intrinsics, config.image_max_edge)
        self._log_cameras(every_nth(intrinsics, self._raster_step))
        for path_, names in ((INSTANCES, ["confirmed", "all live"]), (MEMORY, ["process MB", "voxels MB"])):
            self._stream.log(path_, rr.SeriesLines(names=names), static=True)

    def show(self, frame: Frame, step: Step, mapper: Mapper, stage_ms: Mapping[str, float]) -> None:
        """Log one mapped frame; `stage_ms` are the milliseconds its stages took so far."""
        self._start_frame(frame.index)
        if self._shown == 0:
            self._stream.send_blueprint(_blueprint(behind(frame.pose)))
        self._log_images(frame, step)
        self._log_boxes(mapper)
        self._log_story(step)
        self._log_scalars(mapper, stage_ms)
        self._schedule.observe(step.changed_blocks)
        if self._due(self._config.points_every):
            self._log_points(mapper)
        self._poses.append(frame.pose)
        self._shown += 1

    def skipped(self, frame_index: int, reason: str) -> None:
        """Log that a frame was not used, and why."""
        self._start_frame(frame_index)
        self._stream.log(EVENTS, rr.TextLog(f"skipped frame {frame_index}: {reason}", level="WARN"))

    def finish(self, mapper: Mapper, panoptic: PanopticMap) -> None:
        """Log the finished map in place of the points, and open the recording on an overview of it."""
        self._start_frame(self._last_index + 1)
        self._log_boxes(mapper, always=True)
        mesh = limited(panoptic.mesh, self._config.mesh_max_vertices)
        if not len(mesh.vertices):
            return
        self._stream.log(POINTS, rr.Clear(recursive=True))
        self._stream.log(
            MESH,
            rr.Mesh3D(
                vertex_positions=mesh.vertices,
                vertex_colors=tinted(mesh.colors, mesh.instances),
                triangle_indices=mesh.triangles,
                # Walls and ceilings seen from behind do not hide the room.
                face_rendering=rr.components.MeshFaceRendering.Front,
            ),
        )
        poses = np.array(self._poses)
        self._stream.log(PATH, rr.LineStrips3D([poses[:, :3, 3]], colors=[PATH_COLOR]))
        view = overview(
            mesh.vertices.astype(np.float64), up=-poses[:, :3, 1].mean(axis=0), forward=poses[:, :3, 2].mean(axis=0)
        )
        self._stream.send_blueprint(_blueprint(view))

    def close(self) -> None:
        """Write out what is still pending, for `close_timeout_s` at most; more calls do nothing."""
        if not self._open:
            return
        self._open = False
        try:
            self._stream.flush(timeout_sec=self._config.close_timeout_s)
        except Exception as error:  # Rerun names no class; a timeline that cannot be written must not end a run
            warnings.warn(f"the timeline may be incomplete: {error}", stacklevel=2)
        self._stream.disconnect()

    def _due(self, every: int) -> bool:
        return self._shown % every == 0

    def _start_frame(self, index: int) -> None:
        self._last_index = index
        self._stream.set_time(FRAME, sequence=index)

    def _log_cameras(self, raster_camera: Intrinsics) -> None:
        for path, camera in ((COLOR, self._color_camera), (DEPTH, raster_camera), (IDS, raster_camera)):
            matrix = camera.matrix
            matrix[:2, 2] += 0.5  # Rerun counts from the corner of the first pixel, we from its centre
            size = (camera.width, camera.height)
            pinhole = rr.Pinhole(image_from_camera=matrix, resolution=size, image_plane_distance=0.3)
            self._stream.log(path, pinhole, static=True)

    def _log_images(self, frame: Frame, step: Step) -> None:
        config, n = self._config, self._raster_step
        pose = frame.pose
        self._stream.log(CAMERA, rr.Transform3D(translation=pose[:3, 3], mat3x3=pose[:3, :3]))
        if self._due(config.image_every):
            encoded = jpeg(frame.rgb, self._color_camera, config.jpeg_quality)
            self._stream.log(COLOR, rr.EncodedImage(contents=encoded, media_type="image/jpeg"))
        if self._due(config.depth_every):
            depth = rr.EncodedDepthImage(depth_png(frame.depth[::n, ::n]), media_type="image/png", meter=1000.0)
            self._stream.log(DEPTH, depth)
        if self._due(config.ids_every):
            self._name_ids(int(step.id_image.max(initial=0)))
            self._stream.log(IDS, rr.SegmentationImage(step.id_image[::n, ::n].astype(np.uint16)))

    def _name_ids(self, highest: int) -> None:
        """Give ids their colours before they are first seen in an id image."""
        if highest < self._named_ids or self._named_ids == MAX_IDS:
            return
        self._named_ids = min((highest // NAMED_IDS + 1) * NAMED_IDS, MAX_IDS)
        colors = instance_colors(np.arange(self._named_ids))
        named = [rr.AnnotationInfo(i, f"#{i}", tuple(color)) for i, color in enumerate(colors.tolist())]
        self._stream.log(WORLD, rr.AnnotationContext(named), static=True)

    def _log_boxes(self, mapper: Mapper, always: bool = False) -> None:
        if not (always or self._due(self._config.boxes_every)):
            return
        tracks = [track for track in mapper.tracks if track.confirmed]
        if not tracks:
            self._stream.log(BOXES, rr.Clear(recursive=False))
            return
        ids = np.array([track.id for track in tracks])
        self._stream.log(
            BOXES,
            rr.Boxes3D(
                centers=[track.box.center for track in tracks],
                half_sizes=np.array([track.box.extent for track in tracks]) / 2,
                quaternions=Rotation.from_matrix([track.box.rotation for track in tracks]).as_quat(),
                fill_mode=rr.components.FillMode.MajorWireframe,
                show_labels=True,
                colors=instance_colors(ids),
                labels=[f"#{track.id} {track.class_name or ''}".rstrip() for track in tracks],
            ),
        )

    def _log_story(self, step: Step) -> None:
        for event in events(step):
            self._stream.log(EVENTS, rr.TextLog(event.text, level=event.level))
        if self._config.decisions:
            self._stream.log(DECISIONS, rr.TextDocument(decision_table(step), media_type="text/markdown"))

    def _log_scalars(self, mapper: Mapper, stage_ms: Mapping[str, float]) -> None:
        if new := [name for name in stage_ms if name not in self._stage_names]:
            self._stage_names += new
            self._stream.log(STAGES, rr.SeriesLines(names=self._stage_names), static=True)
        self._stream.log(STAGES, rr.Scalars([stage_ms.get(name, 0.0) for name in self._stage_names]))
        confirmed = sum(track.confirmed for track in mapper.tracks)
        self._stream.log(INSTANCES, rr.Scalars([confirmed, len(mapper.tracks)]))
        self._stream.log(MEMORY, rr.Scalars([rss_mb(), mapper.voxels.memory_bytes / 1e6]))

    def _log_points(self, mapper: Mapper) -> None:
        due = self._schedule.take_due()
        if not due:
            return
        size_m = mapper.voxels.settings.voxel_size_m
        surface = extract_points(mapper.voxels, np.concatenate([chunk.block_keys for chunk in due]))
        points = thinned(surface, size_m, self._config.points_thinning)
        colors = instance_colors(points.instances)
        parts = by_chunk(points, size_m)
        for chunk in due:
            rows = parts.get(chunk, np.zeros(0, np.int64))  # what has been carved away must vanish here too
            cloud = rr.Points3D(points.positions[rows], colors=colors[rows], radii=0.75 * size_m)
            self._stream.log(f"{POINTS}/{chunk.x}_{chunk.y}_{chunk.z}", cloud)


def _blueprint(view: Viewpoint) -> rrb.Blueprint:
    eye = rrb.EyeControls3D(position=view.position, look_target=view.target, eye_up=view.up)
    scene = rrb.Spatial3DView(
        origin=WORLD, name="Map", contents=["$origin/**", f"- {DEPTH}", f"- {IDS}"],
        line_grid=False, eye_controls=eye,
    )  # fmt: skip
    images = rrb.Horizontal(
        rrb.Spatial2DView(origin=COLOR, name="Colour"),
        rrb.Tabs(rrb.Spatial2DView(origin=IDS, name="Instances"), rrb.Spatial2DView(origin=DEPTH, name="Depth")),
    )
    plots = rrb.Tabs(
        rrb.TimeSeriesView(origin=STAGES, name="Milliseconds"),
        rrb.TimeSeriesView(origin=INSTANCES, name="Instances"),
        rrb.TimeSeriesView(origin=MEMORY, name="Memory"),
    )
    words = rrb.Tabs(
        rrb.TextDocumentView(origin=DECISIONS, name="Why"),
        rrb.TextLogView(origin=EVENTS, name="Events", columns=LOG_COLUMNS),
    )
    side = rrb.Vertical(images, plots, words, row_shares=[3, 3, 4])
    return rrb.Blueprint(
        rrb.Horizontal(scene, side, column_shares=[3, 2]),
        rrb.TimePanel(state="collapsed", timeline=FRAME, play_state="following"),
        collapse_panels=True,
    )
