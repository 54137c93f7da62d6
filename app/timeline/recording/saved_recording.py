"""Recordings in files: written by streams, read back, and put together anew."""

from __future__ import annotations

import uuid
import warnings
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import cv2
import numpy as np
import rerun as rr
import rerun.blueprint as rrb
from rerun.error_utils import RerunWarning

from app.timeline.entities import DEPTH, ESTIMATED, FIGURES, PATH
from razer.arrays import Float32Array, Float64Array
from razer.errors import BadInput, one_line
from razer.files import MALFORMED, decode_image, opened
from razer.frame import Intrinsics

STAMP = "stamp_s"  # of a depth image


def open_stream(path: Path, name: str, batches: rr.ChunkBatcherConfig | None = None) -> rr.RecordingStream:
    """A stream that writes a file; streams of one name are one recording."""
    stream = rr.RecordingStream("razer", recording_id=name, send_properties=False, batcher_config=batches)
    stream.set_log_tick_enabled(False)
    stream.set_log_time_enabled(False)
    stream.save(path)
    return stream


def data_of(path: Path) -> rr.chunk.LazyChunkStream:
    """What a file holds but for layouts, in its order; nothing of a file without any."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", RerunWarning)  # that a file which was cut off has no end
        reader = rr.chunk.RrdReader(path)
    return reader.stream() if reader.recordings() else rr.chunk.LazyChunkStream.from_iter([])


def _rows(chunk: rr.chunk.Chunk) -> list[dict]:
    """Its rows by the components' short names, those that are there."""
    found = chunk.to_record_batch().to_pylist()
    return [{key.split(":")[-1]: value for key, value in row.items() if value is not None} for row in found]


class SavedRecording:
    """The data of a recording, read back. Raises BadInput, naming the file, for one that cannot be."""

    def __init__(self, path: Path) -> None:
        self._path = path
        with opened(path):  # whether it is a file at all
            pass
        try:
            self._chunks = data_of(path).to_chunks()
        except Exception as error:  # Rerun names no class
            raise BadInput(f"{path} is no timeline, or a damaged one ({one_line(error)}): make it again") from None

    def holds(self, path: str) -> bool:
        """Whether anything was logged at an entity."""
        return any(chunk.entity_path.lstrip("/") == path for chunk in self._chunks)

    def depth_images(self) -> DepthImages | None:
        """The depth images in it; None of a recording that does not say when they were taken. Raises BadInput."""
        try:
            return self._depth_images()
        except BadInput:
            raise
        except MALFORMED as error:
            raise BadInput(f"{self._path} has depth images that cannot be read ({one_line(error)})") from None

    def _depth_images(self) -> DepthImages | None:
        rows = [row for chunk in self._chunks if chunk.entity_path.lstrip("/") == DEPTH for row in _rows(chunk)]
        size, matrix = (
            next((row[key] for row in rows if key in row), None) for key in ("resolution", "image_from_camera")
        )
        images = {row[STAMP][0]: self._depth_m(bytes(row["blob"][0])) for row in rows if STAMP in row}
        if not images or size is None or matrix is None:
            return None
        (width, height), columns = size[0], np.array(matrix[0]).reshape(3, 3)
        cx, cy = columns[2, :2] - 0.5  # Rerun counts from the corner of the first pixel
        camera = Intrinsics(int(width), int(height), columns[0, 0], columns[1, 1], cx, cy)
        return DepthImages(list(images.values()), np.array([*images]), camera)

    def _depth_m(self, encoded: bytes) -> Float32Array:
        millimetres = decode_image(encoded, f"{self._path}, a depth image", cv2.IMREAD_UNCHANGED)
        return millimetres.astype(np.float32) / np.float32(1000)

    def under(self, name: str) -> list[rr.chunk.Chunk]:
        """All of it below the entity `name`."""
        ours = [chunk for chunk in self._chunks if not chunk.entity_path.startswith("/__")]
        return [chunk.with_entity_path(f"/{name}{chunk.entity_path}") for chunk in ours]


@dataclass(frozen=True)
class DepthImages:
    """Depth images (H, W) in metres, 0 = none, the time of each, seconds, and the camera of all."""

    images_m: list[Float32Array]
    stamps: Float64Array
    camera: Intrinsics


@dataclass(frozen=True)
class RunStyle:
    """How a run is shown among others: moved (4, 4) from its own world into the common one, its path in one colour."""

    world_from_own: Float64Array
    color: tuple[int, int, int]


def write_merged(
    path: Path, chunks: Sequence[rr.chunk.Chunk], layout: rrb.Blueprint, styles: Mapping[str, RunStyle], figures: str
) -> None:
    """Write data of several recordings as one.

    Args:
        path: the file.
        chunks: each under the name of its run.
        layout: of the viewer.
        styles: of the runs, by name.
        figures: Markdown that compares them.
    """
    stream = open_stream(path, str(uuid.uuid4()))
    stream.send_blueprint(layout)
    stream.log(FIGURES, rr.TextDocument(figures, media_type="text/markdown"), static=True)
    for name, style in styles.items():
        motion = style.world_from_own
        stream.log(name, rr.Transform3D(translation=motion[:3, 3], mat3x3=motion[:3, :3]), static=True)
        for line in (PATH, f"{ESTIMATED}/whole", f"{ESTIMATED}/newest"):
            stream.log(f"{name}/{line}", rr.LineStrips3D.from_fields(colors=[style.color]), static=True)
    stream.flush()  # so that these come first: data that was read back is not held back to be batched
    stream.send_chunks(chunks)
    stream.flush()
    stream.disconnect()
