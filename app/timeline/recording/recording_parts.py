"""Parts of a recording: files that are written side by side, and become one when the run ends."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import BinaryIO

import rerun as rr
import rerun.blueprint as rrb

from app.timeline.entities import READ_FIRST
from app.timeline.recording import live_files
from app.timeline.recording.saved_recording import data_of, open_stream


class RecordingParts:
    """The parts of the recording `path`, beside it; the last one is the bulk."""

    def __init__(self, path: Path, count: int) -> None:
        self._path = path
        self.paths = [path.with_name(f"{path.stem}.{number}{path.suffix}") for number in range(count)]
        self._locks: list[BinaryIO] = []

    def lock(self) -> None:
        """Let readers know that the parts are being written."""
        self._locks = [live_files.lock(path) for path in self.paths]

    def unlock(self) -> None:
        """Let readers know that nothing more will come."""
        for file in self._locks:
            file.close()

    def join(self, name: str, layout: rrb.Blueprint | None) -> None:
        """Write the recording, layout and finished map first, the bulk last, and remove the parts."""
        joined = self._path.with_name(f".{self._path.name}.joined")
        stream = open_stream(joined, name)
        if layout is not None:
            stream.send_blueprint(layout)
        *early, bulk = (data_of(part) for part in self.paths)
        stream.send_chunks(sorted(_in_few_chunks(rr.chunk.LazyChunkStream.merge(*early)), key=_reading_rank))
        stream.send_chunks(bulk)
        stream.flush()
        stream.disconnect()
        joined.replace(self._path)
        for part in self.paths:
            part.unlink()


def _in_few_chunks(data: rr.chunk.LazyChunkStream) -> list[rr.chunk.Chunk]:
    """The same in few chunks: what a browser takes to open a recording goes by their number."""
    few = replace(rr.chunk.OptimizationProfile.OBJECT_STORE, gop_batching=False)
    return data.collect(optimize=few).stream().to_chunks()


def _reading_rank(chunk: rr.chunk.Chunk) -> int:
    """The finished map first, then plots, then all else."""
    path = chunk.entity_path.lstrip("/")
    return next((rank for rank, first in enumerate(READ_FIRST) if path.startswith(first)), len(READ_FIRST))
