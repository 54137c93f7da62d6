"""Recordings of a run, finished or still being written.

A run writes its timeline in parts, in its hidden folder, and holds a lock on each part until it is done with it: so a
reader can tell a part that grows from one that a killed run left behind.
"""

from __future__ import annotations

import fcntl
import os
import time
from collections.abc import Iterator
from pathlib import Path
from typing import BinaryIO

from app.run_folder.run_folder import TIMELINE, TIMELINE_PARTS

READ_BYTES = 1 << 18
POLL_S = 0.2


def recordings_at(place: Path) -> list[Path]:
    """The parts of the run that is being written to `place`, else the timeline of the run that is there; `place` may
    be a recording itself. None where there is none."""
    if place.suffix == ".rrd":
        return [place] if place.is_file() else []
    if live := live_parts(place):
        return live
    return [place / TIMELINE] if (place / TIMELINE).is_file() else []


def live_parts(run: Path) -> list[Path]:
    """The parts that are being written by a run that will be `run`, first what is to be read first."""
    final = Path(os.path.abspath(run))
    return [part for part in sorted(final.parent.glob(f".{final.name}.partial-*/{TIMELINE_PARTS}")) if is_written(part)]


def lock(path: Path) -> BinaryIO:
    """Hold the lock of a part that exists, for as long as the file returned is open."""
    file = path.open("rb")
    fcntl.flock(file, fcntl.LOCK_SH)
    return file


def is_written(part: Path) -> bool:
    """Whether somebody still writes a part."""
    try:
        with part.open("rb") as file:
            return _is_locked(file)
    except FileNotFoundError:
        return False


def growing(file: BinaryIO) -> Iterator[bytes]:
    """The bytes of a file up to its end, and what comes as long as somebody writes it."""
    is_last = False
    while not is_last:
        is_last = not _is_locked(file)  # before it is read: what was written until then is all
        while part := file.read(READ_BYTES):
            yield part
        if not is_last:
            time.sleep(POLL_S)


def _is_locked(file: BinaryIO) -> bool:
    try:
        fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except BlockingIOError:
        return True
    fcntl.flock(file, fcntl.LOCK_UN)
    return False
