"""Adapter to the Rerun SDK, and the only importer of rerun: our value types in, Rerun's archetypes out.

Logging hands data to Rerun's own thread, which writes the file; only `close` waits for it, and not for ever.
"""

from __future__ import annotations

import warnings
from collections.abc import Sequence
from pathlib import Path

import numpy as np
import rerun as rr
import rerun.blueprint as rrb
from scipy.spatial.transform import Rotation

from app.render.viewpoint import Viewpoint
from app.timeline import entities
from app.timeline.ellipsoids import Ellipsoids
from razer.arrays import Float32Array, Float64Array, FloatArray, Uint8Array, Uint16Array
from razer.boxes.oriented_box import OrientedBox
from razer.frame import Intrinsics
from razer.mesh.labelled_mesh import LabelledMesh

FRAME = "frame"  # the one clock: the index of the frame
# Larger chunks than Rerun's own: a browser opens the recording many times faster.
BATCHES = rr.ChunkBatcherConfig(flush_tick=10, flush_num_bytes=4 * 2**20)
LOG_COLUMNS = rrb.TextLogColumns(text_log_columns=["LogLevel", "Body"])


class RerunLog:
    """Writes the recording `path`; `close` it, whatever happened. Paths are those of Rerun's entities; colours are
    (N, 3) uint8 or one for all."""

    def __init__(self, path: Path) -> None:
        self._stream = rr.RecordingStream("razer", batcher_config=BATCHES)
        self._stream.set_log_tick_enabled(False)
        self._stream.set_log_time_enabled(False)
        self._stream.save(path)
        self._open = True

    def start_frame(self, index: int) -> None:
        """What follows belongs to the frame `index`."""
        self._stream.set_time(FRAME, sequence=index)

    def camera(self, path: str, camera: Intrinsics) -> None:
        """The camera of the images under `path`."""
        matrix = camera.matrix
        matrix[:2, 2] += 0.5  # Rerun counts from the corner of the first pixel, we from its centre
        size = (camera.width, camera.height)
        pinhole = rr.Pinhole(image_from_camera=matrix, resolution=size, image_plane_distance=0.3)
        self._stream.log(path, pinhole, static=True)

    def pose(self, path: str, world_from_camera: Float64Array) -> None:
        """Where a camera is, (4, 4)."""
        pose = world_from_camera
        self._stream.log(path, rr.Transform3D(translation=pose[:3, 3], mat3x3=pose[:3, :3]))

    def jpeg(self, path: str, encoded: bytes) -> None:
        """A colour image."""
        self._stream.log(path, rr.EncodedImage(contents=encoded, media_type="image/jpeg"))

    def depth_png(self, path: str, encoded: bytes) -> None:
        """A depth image in millimetres."""
        self._stream.log(path, rr.EncodedDepthImage(encoded, media_type="image/png", meter=1000.0))

    def ids(self, path: str, image: Uint16Array) -> None:
        """An image (H, W) of ids."""
        self._stream.log(path, rr.SegmentationImage(image))

    def name_ids(self, path: str, colors: Uint8Array) -> None:
        """The colours (N, 3) of ids 0 to N - 1 in the images under `path`."""
        named = [rr.AnnotationInfo(i, f"#{i}", tuple(color)) for i, color in enumerate(colors.tolist())]
        self._stream.log(path, rr.AnnotationContext(named), static=True)

    def boxes(self, path: str, boxes: Sequence[OrientedBox], colors: Uint8Array, labels: Sequence[str]) -> None:
        """Log wire frames.

        Args:
            path: of the entity.
            boxes: N boxes.
            colors: (N, 3) of the boxes.
            labels: N texts beside them.
        """
        self._stream.log(
            path,
            rr.Boxes3D(
                centers=[box.center for box in boxes],
                half_sizes=np.array([box.extent for box in boxes]) / 2,
                quaternions=Rotation.from_matrix([box.rotation for box in boxes]).as_quat(),
                fill_mode=rr.components.FillMode.MajorWireframe,
                show_labels=True,
                colors=colors,
                labels=list(labels),
            ),
        )

    def points(self, path: str, positions: Float32Array, colors: Uint8Array, radius_m: float) -> None:
        """Log a point cloud.

        Args:
            path: of the entity.
            positions: (N, 3) metres.
            colors: (N, 3) of the points.
            radius_m: of every point, metres.
        """
        self._stream.log(path, rr.Points3D(positions, colors=colors, radii=radius_m))

    def dots(self, path: str, positions: Float64Array, color: tuple[int, int, int], radius_points: float) -> None:
        """Log points that are as large on the screen from near as from afar.

        Args:
            path: of the entity.
            positions: (N, 3) metres.
            color: of all points.
            radius_points: of every point, points on the screen.
        """
        radius = rr.components.Radius.ui_points(radius_points)
        self._stream.log(path, rr.Points3D(positions, colors=[color], radii=radius))

    def mesh(self, path: str, mesh: LabelledMesh, colors: Uint8Array) -> None:
        """A surface in other colours (V, 3) than its own."""
        self._stream.log(
            path,
            rr.Mesh3D(
                vertex_positions=mesh.vertices,
                vertex_colors=colors,
                triangle_indices=mesh.triangles,
                # Walls and ceilings seen from behind do not hide the room.
                face_rendering=rr.components.MeshFaceRendering.Front,
            ),
        )

    def line_style(self, path: str, color: tuple[int, int, int], radius_points: float = 1.5) -> None:
        """The colour of all lines at `path`, whenever they come, and half their width on the screen: to send these
        with each costs as much as the lines."""
        radius = rr.components.Radius.ui_points(radius_points)
        self._stream.log(path, rr.LineStrips3D.from_fields(colors=[color], radii=radius), static=True)

    def lines(self, path: str, strips: Sequence[FloatArray] | Float64Array) -> None:
        """Lines through the points (N, 3) of each strip; all at once as (M, N, 3) is faster."""
        self._stream.log(path, rr.LineStrips3D(strips))

    def ellipsoids(self, path: str, ellipsoids: Ellipsoids, color: tuple[int, int, int]) -> None:
        """Transparent, with their main circles."""
        self._stream.log(
            path,
            rr.Ellipsoids3D(
                centers=ellipsoids.centers,
                half_sizes=ellipsoids.half_sizes,
                quaternions=Rotation.from_matrix(ellipsoids.rotations).as_quat(),
                fill_mode=rr.components.FillMode.TransparentFillMajorWireframe,
                colors=[color],
            ),
        )

    def clear(self, path: str, *, recursive: bool) -> None:
        """Nothing is at `path` any more, or below it."""
        self._stream.log(path, rr.Clear(recursive=recursive))

    def event(self, path: str, text: str, level: str) -> None:
        """A line of text."""
        self._stream.log(path, rr.TextLog(text, level=level))

    def document(self, path: str, markdown: str) -> None:
        """A text in place of the one before."""
        self._stream.log(path, rr.TextDocument(markdown, media_type="text/markdown"))

    def name_series(self, path: str, names: Sequence[str]) -> None:
        """What the curves of a plot are called."""
        self._stream.log(path, rr.SeriesLines(names=list(names)), static=True)

    def scalars(self, path: str, values: Sequence[float]) -> None:
        """The next value of each curve."""
        self._stream.log(path, rr.Scalars(list(values)))

    def show(self, layout: rrb.Blueprint) -> None:
        """How the viewer lays the recording out."""
        self._stream.send_blueprint(layout)

    def close(self, timeout_s: float) -> None:
        """Write out what is still pending, for `timeout_s` at most; more calls do nothing."""
        if not self._open:
            return
        self._open = False
        try:
            self._stream.flush(timeout_sec=timeout_s)
        except Exception as error:  # Rerun names no class; a recording that cannot be written must not end a run
            warnings.warn(f"the timeline may be incomplete: {error}", stacklevel=3)
        self._stream.disconnect()


def run_layout(view: Viewpoint, *, poses_estimated: bool = False) -> rrb.Blueprint:
    """The layout of a run: the map as seen from `view`, the images, the plots, what happened and why; where poses are
    estimated, plots of that come first."""
    scene = _scene(entities.WORLD, "Map", ["$origin/**", f"- {entities.DEPTH}", f"- {entities.IDS}"], view)
    images = rrb.Horizontal(
        rrb.Spatial2DView(origin=entities.COLOR, name="Colour"),
        rrb.Tabs(
            rrb.Spatial2DView(origin=entities.IDS, name="Instances"),
            rrb.Spatial2DView(origin=entities.DEPTH, name="Depth"),
        ),
    )
    plots = rrb.Tabs(
        *(_pose_plots() if poses_estimated else ()),
        rrb.TimeSeriesView(origin=entities.STAGES, name="Milliseconds"),
        rrb.TimeSeriesView(origin=entities.INSTANCES, name="Instances"),
        rrb.TimeSeriesView(origin=entities.MEMORY, name="Memory"),
    )
    texts = rrb.Tabs(
        rrb.TextDocumentView(origin=entities.DECISIONS, name="Why"),
        rrb.TextLogView(origin=entities.EVENTS, name="Events", columns=LOG_COLUMNS),
    )
    side = rrb.Vertical(images, plots, texts, row_shares=[3, 3, 4])
    return rrb.Blueprint(
        rrb.Horizontal(scene, side, column_shares=[3, 2]),
        rrb.TimePanel(state="collapsed", timeline=FRAME, play_state="following"),
        collapse_panels=True,
    )


def _pose_plots() -> list[rrb.TimeSeriesView]:
    names = {
        entities.TRACKING: "Tracking",
        entities.FEATURES_FOUND: "Features",
        entities.SIGMA: "Sigma",
        entities.GRAPH_SIZE: "Pose graph",
        entities.TRACKING_MS: "Tracking ms",
    }
    return [rrb.TimeSeriesView(origin=origin, name=name) for origin, name in names.items()]


def scene_layout(view: Viewpoint) -> rrb.Blueprint:
    """One view of all there is, beside the tree in which each part can be shown and hidden."""
    return rrb.Blueprint(
        _scene("/", "Maps", ["$origin/**"], view),
        rrb.BlueprintPanel(state="expanded"),
        rrb.SelectionPanel(state="collapsed"),
        rrb.TimePanel(state="collapsed"),
        auto_views=False,
    )


def _scene(origin: str, name: str, contents: list[str], view: Viewpoint) -> rrb.Spatial3DView:
    eye = rrb.EyeControls3D(position=view.position, look_target=view.target, eye_up=view.up)
    return rrb.Spatial3DView(origin=origin, name=name, contents=contents, line_grid=False, eye_controls=eye)
