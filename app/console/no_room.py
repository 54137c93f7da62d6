"""Errors of a system that has no room left, or lets nothing be written: no fault of the program, said in one line.

Libraries written in C++ tell of memory that ran out in words of their own, and in errors of any class.
"""

from __future__ import annotations

from errno import (
    EACCES,
    EAGAIN,
    EDQUOT,
    EEXIST,
    EFBIG,
    EIO,
    EISDIR,
    ELOOP,
    EMFILE,
    ENAMETOOLONG,
    ENFILE,
    ENOMEM,
    ENOSPC,
    ENOTDIR,
    ENOTEMPTY,
    EPERM,
    EROFS,
)  # fmt: skip

NO_ROOM = (EDQUOT, EFBIG, EIO, ENAMETOOLONG, ENOSPC, EROFS)  # where it is written
_IN_THE_WAY = (EACCES, EEXIST, EISDIR, ELOOP, ENOTDIR, ENOTEMPTY, EPERM)  # where a file is named
_TOO_MANY_FILES = (EMFILE, ENFILE)
_SPARE_BYTES = 64 * 2**20
_MEMORY = "memory ran out: use fewer or smaller frames, larger voxels, or another machine"
_PROCESSES = "no more threads or processes can be started: end others, or raise the limit (ulimit -u)"
_ENDED = "a helper process was ended by the system, most often because memory ran out: use fewer or smaller frames"
_FILES = "too many files are open: raise the limit (ulimit -n)"
_SAID_BY_LIBRARIES = {
    _MEMORY: (
        "bad_alloc",
        "bad alloc",
        "malloc failed",
        "failed to allocate",
        "unable to allocate",
        "allocate memory",  # cannot, and can't
        "out of memory",
        "not enough memory",
        "insufficient memory",
        "failed to map segment",  # of a library that is loaded
    ),
    _ENDED: ("terminated abruptly",),  # a process of a pool
    _PROCESSES: ("can't start new thread", "thread creation failed", "resource temporarily unavailable"),
    _FILES: ("too many open files",),
}


def no_room_line(error: BaseException) -> str | None:
    """What to say of an error for which the system has no room, or that it refuses; None for any other."""
    if isinstance(error, MemoryError):
        return _MEMORY
    if isinstance(error, OSError) and error.errno is not None:
        return _refusal(error)
    if isinstance(error, SystemError) and _is_short_of_memory():
        return _MEMORY
    if isinstance(error, ImportError) and isinstance(error.__cause__, ImportError):  # of a verb: why, its cause says
        return no_room_line(error.__cause__)
    said = str(error).lower()
    return next((line for line, words in _SAID_BY_LIBRARIES.items() if any(word in said for word in words)), None)


def _is_short_of_memory() -> bool:
    """Whether the system refuses some more now: the interpreter itself may forget why it failed."""
    try:
        bytearray(_SPARE_BYTES)
    except MemoryError:
        return True
    return False


def _refusal(error: OSError) -> str | None:
    if error.errno == ENOMEM:
        return _MEMORY
    if error.errno == EAGAIN:
        return _PROCESSES
    if error.errno in _TOO_MANY_FILES:
        return _FILES
    if error.errno in NO_ROOM:
        place = f"{error.filename}: " if error.filename else ""
        return f"{place}{error.strerror}: free some space, or choose another place"
    if error.errno in _IN_THE_WAY and error.filename:
        return f"{error.filename}: {error.strerror}: choose another place"
    return None
