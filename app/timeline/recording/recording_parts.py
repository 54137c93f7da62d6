"""Parts of a recording: files that are written side by side, and become one when the run ends."""

from __future__ import annotations

import os
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import BinaryIO

import rerun as rr
import rerun.blueprint as rrb

from app.timeline.entities import READ_FIRST
from app.timeline.recording import live_files
from app.timeline.recording.saved_recording import data_of, open_stream
from razer.errors import BadInput


class RecordingParts:
    """The parts of the recording `path`, beside it, `count` at a time; the last of these is the bulk."""

    def __init__(self, path: Path, count: int, written: Sequence[tuple[str, int]] = ()) -> None:
        """`written`: names of earlier parts, and how many bytes of each are whole: they are cut off there."""
        self._path = path
        self._earlier = [path.with_name(name) for name, _ in written]
        for part, (_, size) in zip(self._earlier, written, strict=True):
            _cut(part, size)
        again = f".{len(written) // count}" if written else ""
        self.paths = [path.with_name(f"{path.stem}.{number}{again}{path.suffix}") for number in range(count)]
        self._locks: list[BinaryIO] = []

    def sizes(self) -> tuple[tuple[str, int], ...]:
        """Names of all parts with their sizes in bytes, the earlier ones first."""
        return tuple((part.name, part.stat().st_size) for part in (*self._earlier, *self.paths))

    def lock(self) -> None:
        """Let readers know that the parts are being written."""
        self._locks = [live_files.lock(path) for path in self.paths]

    def unlock(self) -> None:
        """Let readers know that nothing more will come."""
        for file in self._locks:
            file.close()

    def join(self, name: str, layout: rrb.Blueprint | None) -> None:
        """Write the recording, layout and finished map first, the bulk last."""
        joined = self._path.with_name(f".{self._path.name}.joined")
        stream = open_stream(joined, name)
        if layout is not None:
            stream.send_blueprint(layout)
        parts, count = [*self._earlier, *self.paths], len(self.paths)
        early = [data_of(part) for number, part in enumerate(parts) if (number + 1) % count]
        stream.send_chunks(sorted(_in_few_chunks(rr.chunk.LazyChunkStream.merge(*early)), key=_reading_rank))
        for bulk in parts[count - 1 :: count]:
            stream.send_chunks(data_of(bulk))
        stream.flush()
        stream.disconnect()
        joined.replace(self._path)

    def remove(self) -> None:
        """Remove the parts, which are joined by now."""
        for part in (*self._earlier, *self.paths):
            part.unlink()


def _cut(part: Path, size: int) -> None:
    """Leave the first bytes of a part; raises BadInput where they are not there."""
    try:
        if part.stat().st_size < size:
            raise BadInput(f"{part} is cut off: the run cannot be resumed")
        os.truncate(part, size)
    except OSError as error:
        raise BadInput(f"{part}: {error.strerror}: the run cannot be resumed") from error


def _in_few_chunks(data: rr.chunk.LazyChunkStream) -> list[rr.chunk.Chunk]:
    """The same in few chunks: what a browser takes to open a recording goes by their number."""
    few = replace(rr.chunk.OptimizationProfile.OBJECT_STORE, gop_batching=False)
    return data.collect(optimize=few).stream().to_chunks()


def _reading_rank(chunk: rr.chunk.Chunk) -> int:
    """The finished map first, then plots, then all else."""
    path = chunk.entity_path.lstrip("/")
    return next((rank for rank, first in enumerate(READ_FIRST) if path.startswith(first)), len(READ_FIRST))
