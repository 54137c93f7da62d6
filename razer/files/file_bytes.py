"""Bytes of regular files, within bounds: a pipe, a device or a folder is refused before it is read."""

from __future__ import annotations

import os
import stat
from collections.abc import Iterator
from contextlib import contextmanager
from io import BufferedReader
from pathlib import Path

from razer.errors import BadInput

MAX_BYTES = 4 * 2**30  # of a file that is read whole: a mesh of 100 million triangles
_WITHOUT_WAITING = os.O_RDONLY | getattr(os, "O_NONBLOCK", 0) | getattr(os, "O_CLOEXEC", 0) | getattr(os, "O_BINARY", 0)
_KINDS = (
    (stat.S_ISDIR, "a folder"),
    (stat.S_ISFIFO, "a pipe"),
    (stat.S_ISSOCK, "a socket"),
    (stat.S_ISCHR, "a device"),
    (stat.S_ISBLK, "a device"),
)


class MissingFile(BadInput):
    """A file that does not exist."""


@contextmanager
def opened(path: Path) -> Iterator[BufferedReader]:
    """A regular file, open for reading bytes; raises BadInput for anything else, without waiting for one who writes to
    a pipe, and for an OSError in the block."""
    try:
        # Opening a pipe to read would wait for its writer, and looking first would leave time to put one there.
        descriptor = os.open(path, _WITHOUT_WAITING)
        try:
            _require_regular(path, os.fstat(descriptor).st_mode)
        except BadInput:
            os.close(descriptor)
            raise
        with os.fdopen(descriptor, "rb") as file:
            yield file
    except FileNotFoundError:
        raise MissingFile(f"{path} cannot be read: No such file, give one that is there") from None
    except OSError as error:
        raise BadInput(f"{path} cannot be read: {error.strerror or error}") from None
    except ValueError as error:
        if "null byte" not in str(error):
            raise
        raise BadInput(f"{path} is no path, as there is a NUL character in it: correct it") from None


def read_bytes(path: Path, max_bytes: int = MAX_BYTES) -> bytes:
    """The content of a regular file of at most `max_bytes`; raises BadInput."""
    with opened(path) as file:
        size = os.fstat(file.fileno()).st_size
        data = file.read(max_bytes + 1) if size <= max_bytes else b""
    if size > max_bytes or len(data) > max_bytes:
        raise BadInput(f"{path} has {size:,} bytes where {max_bytes:,} are the most: give a smaller file")
    return data


def beginning(path: Path, n_bytes: int) -> bytes:
    """The first bytes of a file, by which its kind is told; none of what cannot be read."""
    try:
        with opened(path) as file:
            return file.read(n_bytes)
    except BadInput:
        return b""


@contextmanager
def plain_os_errors(path: Path) -> Iterator[None]:
    """What the system refuses in the block, such as to look into a closed folder, is bad input that names `path`, or
    the file that the system names."""
    try:
        yield
    except OSError as error:
        raise BadInput(f"{error.filename or path} cannot be read: {error.strerror or error}") from None


def _require_regular(path: Path, mode: int) -> None:
    if not stat.S_ISREG(mode):
        kind = next((name for is_kind, name in _KINDS if is_kind(mode)), "something else")
        raise BadInput(f"{path} is {kind}: give a file")
