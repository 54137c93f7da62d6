"""The file of an edit log, edits.jsonl: only ever appended to, by one writer at a time, a whole line or nothing."""

from __future__ import annotations

import fcntl
import json
import os
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from razer.edits.log import FORMAT, EditLog, Entry
from razer.errors import BadInput
from razer.storage.file_names import EDITS

_HEADER = json.dumps({"format": FORMAT, "kind": "log"}).encode() + b"\n"


class LockedLog:
    """The log while no other process, and no other thread, can write to it."""

    def __init__(self, folder: Path, descriptor: int) -> None:
        self._descriptor = descriptor
        self.log = EditLog.read(folder)

    def append(self, entry: Entry) -> EditLog:
        """Write one entry and carry it through to the disk; the log as it is then. Raises OSError, with the file as it
        was."""
        size = self._whole_lines()
        line = json.dumps(entry.to_json(), ensure_ascii=False).encode() + b"\n"
        try:
            _write(self._descriptor, line if size else _HEADER + line)
            os.fsync(self._descriptor)
        except OSError:
            os.ftruncate(self._descriptor, size)
            raise
        self.log = self.log.appended(entry)
        return self.log

    def _whole_lines(self) -> int:
        """The length in bytes, without a last line that whoever wrote it did not live to end."""
        data = os.pread(self._descriptor, os.fstat(self._descriptor).st_size, 0)
        size = data.rfind(b"\n") + 1
        if size < len(data):
            os.ftruncate(self._descriptor, size)
        return size


@contextmanager
def locked_log(folder: Path) -> Iterator[LockedLog]:
    """The log of a folder, for one writer; others wait. Raises BadInput where it cannot be written or is damaged."""
    try:
        descriptor = _locked(folder / EDITS)
    except OSError as error:
        raise BadInput(f"{folder / EDITS} cannot be written ({error.strerror}): nothing was changed") from error
    try:
        yield LockedLog(folder, descriptor)
    except OSError as error:
        raise BadInput(f"{folder / EDITS} cannot be written ({error.strerror}): nothing was changed") from error
    finally:
        if not os.fstat(descriptor).st_size:  # nothing was written, and there was no log before
            (folder / EDITS).unlink(missing_ok=True)
        os.close(descriptor)  # which unlocks it


def _locked(path: Path) -> int:
    """A descriptor of the file that lies there once it is locked: the folder may be replaced while one waits."""
    while True:
        descriptor = os.open(path, os.O_RDWR | os.O_CREAT | os.O_APPEND | os.O_CLOEXEC, 0o666)
        fcntl.flock(descriptor, fcntl.LOCK_EX)
        try:
            if os.path.samestat(os.fstat(descriptor), os.stat(path)):
                return descriptor
        except FileNotFoundError:
            pass
        os.close(descriptor)


def _write(descriptor: int, data: bytes) -> None:
    while data:
        data = data[os.write(descriptor, data) :]
