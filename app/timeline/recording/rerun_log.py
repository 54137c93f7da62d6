"""Adapter to the Rerun SDK: our value types in, Rerun's archetypes out.

Logging hands data to Rerun's own threads, which write files; only `close` waits for them, and not for ever. What a
viewer should show first is written to a file of its own, and so is the bulk that it should read last; `close` joins
them.
"""

from __future__ import annotations

import uuid
import warnings
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from pathlib import Path

import numpy as np
import rerun as rr
import rerun.blueprint as rrb
from scipy.spatial.transform import Rotation

from app.console.leaving import note_stuck
from app.stored_state.written_log import WrittenLog
from app.timeline import entities
from app.timeline.recording.ellipsoids import Ellipsoids
from app.timeline.recording.recording_parts import RecordingParts
from app.timeline.recording.saved_recording import STAMP, open_stream
from razer.arrays import Float32Array, Float64Array, FloatArray, Uint8Array
from razer.boxes.oriented_box import OrientedBox
from razer.frame import Intrinsics
from razer.mesh.labelled_mesh import LabelledMesh

FRAME = "frame"  # the one clock: the index of the frame
BATCH_BYTES = 4 * 2**20  # larger chunks than Rerun's own: a browser opens the recording many times faster
BATCH_S, LIVE_BATCH_S = 10.0, 1.0
FIRST, CURVES, FRAMES = range(3)  # the parts of a recording, in the order in which a viewer reads them
Color = tuple[int, int, int]
DARK: Color = (30, 30, 30)
NAMES = "names"  # of dots, below these


class RerunLog:
    """Writes the recording `path`; `close` it, whatever happened. Paths are those of Rerun's entities; colours are
    (N, 3) uint8 or one for all. What is `live` can be watched with a second's delay, for a larger file."""

    def __init__(self, path: Path, *, live: bool = False, written: WrittenLog | None = None) -> None:
        """A new recording, or one that goes on after what was `written` of it before."""
        batches = rr.ChunkBatcherConfig(flush_tick=LIVE_BATCH_S if live else BATCH_S, flush_num_bytes=BATCH_BYTES)
        self._path = path
        self._name = str(uuid.uuid4()) if written is None else written.name
        self._parts = RecordingParts(path, len((FIRST, CURVES, FRAMES)), () if written is None else written.sizes)
        self._streams = [open_stream(part, self._name, batches) for part in self._parts.paths]
        self._parts.lock()
        self._layout: rrb.Blueprint | None = None
        self._in_front = False
        self._open = True

    def written(self, timeout_s: float) -> WrittenLog | None:
        """What of the recording is on the disk, once all that was logged is: waits so long at most; None where it
        cannot be written."""
        try:
            for stream in self._streams:
                stream.flush(timeout_sec=timeout_s)
        except RuntimeError:  # Rerun's, for a full disk as well
            note_stuck("rerun", self._streams)
            return None
        return WrittenLog(self._name, self._parts.sizes())

    @contextmanager
    def in_front(self) -> Iterator[None]:
        """What is logged in this context is what a viewer reads first."""
        self._in_front = True
        yield
        self._in_front = False

    def _log(self, path: str, what: rr.AsComponents, *more: rr.AsComponents, static: bool = False) -> None:
        self._stream(path, static).log(path, what, *more, static=static)

    def _stream(self, path: str, static: bool = False) -> rr.RecordingStream:
        if self._in_front or static:
            return self._streams[FIRST]
        return self._streams[FRAMES if path.startswith(entities.FRAME_BY_FRAME) else CURVES]

    def start_frame(self, index: int) -> None:
        """What follows belongs to the frame `index`."""
        for stream in self._streams:
            stream.set_time(FRAME, sequence=index)

    def camera(self, path: str, camera: Intrinsics) -> None:
        """The camera of the images under `path`."""
        matrix = camera.matrix
        matrix[:2, 2] += 0.5  # Rerun counts from the corner of the first pixel, we from its centre
        size = (camera.width, camera.height)
        pinhole = rr.Pinhole(image_from_camera=matrix, resolution=size, image_plane_distance=0.3)
        self._log(path, pinhole, static=True)

    def pose(self, path: str, world_from_camera: Float64Array) -> None:
        """Where a camera is, (4, 4)."""
        pose = world_from_camera
        self._log(path, rr.Transform3D(translation=pose[:3, 3], mat3x3=pose[:3, :3]))

    def jpeg(self, path: str, encoded: bytes) -> None:
        """A colour image."""
        self._log(path, rr.EncodedImage(contents=encoded, media_type="image/jpeg"))

    def depth_png(self, path: str, encoded: bytes, stamp_s: float) -> None:
        """A depth image in millimetres, and when it was taken, by which poses can be found again."""
        image = rr.EncodedDepthImage(encoded, media_type="image/png", meter=1000.0)
        self._log(path, image, rr.AnyValues(**{STAMP: stamp_s}))

    def boxes(self, path: str, boxes: Sequence[OrientedBox], colors: Uint8Array, labels: Sequence[str] = ()) -> None:
        """Log wire frames.

        Args:
            path: of the entity.
            boxes: N boxes.
            colors: (N, 3) of the boxes.
            labels: N texts, shown beside the one that is pointed at, or none.
        """
        self._log(
            path,
            rr.Boxes3D(
                centers=[box.center for box in boxes],
                half_sizes=np.array([box.extent for box in boxes]) / 2,
                quaternions=Rotation.from_matrix([box.rotation for box in boxes]).as_quat(),
                fill_mode=rr.components.FillMode.MajorWireframe,
                show_labels=False,
                colors=colors,
                labels=list(labels) or None,
            ),
        )

    def dots(
        self, path: str, positions: Float64Array, color: Color, radius_points: float, labels: Sequence[str] = ()
    ) -> None:
        """Log points that are as large on the screen from near as from afar.

        Args:
            path: of the entity.
            positions: (N, 3) metres.
            color: of all points.
            radius_points: of every point, points on the screen.
            labels: N texts beside them, dark as a text takes the colour of its point, or none.
        """
        radius = rr.components.Radius.ui_points(radius_points)
        self._log(path, rr.Points3D(positions, colors=[color], radii=radius))
        if labels:
            self.labels(f"{path}/{NAMES}", positions, labels)

    def mesh(self, path: str, mesh: LabelledMesh, colors: Uint8Array) -> None:
        """A surface in other colours (V, 3) than its own."""
        self._log(
            path,
            rr.Mesh3D(
                vertex_positions=mesh.vertices,
                vertex_colors=colors,
                triangle_indices=mesh.triangles,
                # Walls and ceilings seen from behind do not hide the room.
                face_rendering=rr.components.MeshFaceRendering.Front,
            ),
        )

    def line_style(self, path: str, color: Color, radius_points: float = 1.5) -> None:
        """The colour of all lines at `path`, whenever they come, and half their width on the screen: to send these
        with each costs as much as the lines."""
        radius = rr.components.Radius.ui_points(radius_points)
        self._log(path, rr.LineStrips3D.from_fields(colors=[color], radii=radius), static=True)

    def lines(self, path: str, strips: Sequence[FloatArray] | Float64Array) -> None:
        """Lines through the points (N, 3) of each strip; all at once as (M, N, 3) is faster."""
        self._log(path, rr.LineStrips3D(strips))

    def ellipsoids(self, path: str, ellipsoids: Ellipsoids, color: Color) -> None:
        """Transparent, with their main circles."""
        self._log(
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
        self._log(path, rr.Clear(recursive=recursive))

    def event(self, path: str, text: str, level: str) -> None:
        """A line of text."""
        self._log(path, rr.TextLog(text, level=level))

    def document(self, path: str, markdown: str) -> None:
        """A text in place of the one before."""
        self._log(path, rr.TextDocument(markdown, media_type="text/markdown"))

    def scalars(self, path: str, values: Sequence[float]) -> None:
        """The next value of each curve."""
        self._log(path, rr.Scalars(list(values)))

    def labels(self, path: str, positions: Float64Array, texts: Sequence[str]) -> None:
        """Dark texts at points (N, 3)."""
        radius = rr.components.Radius.ui_points(1.5)
        self._log(path, rr.Points3D(positions, labels=list(texts), colors=[DARK], radii=radius, show_labels=True))

    def item(self, path: str, box: OrientedBox, points: Float32Array, color: Color, label: str) -> None:
        """One thing: its box with a label for who points at it, and its surface as points (N, 3) that stand for it when
        clicked on."""
        self.boxes(path, [box], np.array([color], np.uint8), [label])
        radius = rr.components.Radius.ui_points(1.8)
        self._log(path, rr.Points3D(points, colors=[color], radii=radius))

    def facts(self, path: str, facts: Mapping[str, str | float]) -> None:
        """Named values that a viewer shows when the entity is selected."""
        self._log(path, rr.AnyValues(**facts))

    def texts(self, path: str, frames: Sequence[int], texts: Sequence[str]) -> None:
        """Lines of text at past frames."""
        levels = [rr.TextLogLevel.INFO] * len(texts)
        columns = rr.TextLog.columns(text=list(texts), level=levels)
        self._stream(path).send_columns(path, [rr.TimeColumn(FRAME, sequence=list(frames))], columns)

    def curve(self, path: str, frames: Sequence[int], values: Sequence[float]) -> None:
        """A curve at past frames."""
        columns = rr.Scalars.columns(scalars=list(values))
        self._stream(path).send_columns(path, [rr.TimeColumn(FRAME, sequence=list(frames))], columns)

    def legend(self, path: str, names: Sequence[str], colors: Sequence[Color]) -> None:
        """Names beside dots of their colours, one below the other."""
        places = [(0.0, float(row)) for row in range(len(names))]
        radius = rr.components.Radius.ui_points(5)
        self._log(path, rr.Points2D(places, colors=list(colors), radii=radius), static=True)
        words = rr.Points2D(places, colors=[DARK], labels=list(names), radii=0.0, show_labels=True)
        self._log(f"{path}/{NAMES}", words, static=True)

    def series(
        self, path: str, names: Sequence[str], colors: Sequence[Color] | None = None, *, width: float = 1.5
    ) -> None:
        """What the curves of a plot are called, and their colours."""
        self._log(path, rr.SeriesLines(names=list(names), colors=colors, widths=[width] * len(names)), static=True)

    def marks(self, path: str, name: str, color: Color, shape: str) -> None:
        """The curve at `path` is marks without a line between them."""
        style = rr.SeriesPoints(names=[name], colors=[color], markers=[shape], marker_sizes=[5.0])
        self._log(path, style, static=True)

    def show(self, layout: rrb.Blueprint) -> None:
        """How the viewer lays the recording out."""
        self._layout = layout
        self._streams[FIRST].send_blueprint(layout)

    def close(self, timeout_s: float, *, join: bool = True, keep_parts: bool = False) -> None:
        """Write out what is still pending, for `timeout_s` at most, `join` the parts, and remove them; more calls do
        nothing."""
        if not self._open:
            return
        self._open = False
        try:
            self._disconnect(timeout_s)
            if join:
                self._parts.join(self._name, self._layout)
            if not keep_parts:
                self._parts.remove()
        except Exception as error:  # Rerun names no class; a recording that cannot be written must not end a run
            warnings.warn(f"the timeline may be incomplete: {error}", stacklevel=3)
            note_stuck("rerun", self._streams)  # its streams go on waiting for a file that they cannot write
        finally:
            self._parts.unlock()

    def _disconnect(self, timeout_s: float) -> None:
        for stream in self._streams:
            stream.flush(timeout_sec=timeout_s)
            stream.disconnect()
