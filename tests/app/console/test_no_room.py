"""No room and no permission, in the words of whoever says so, are one line; errors of the program are none."""

from __future__ import annotations

import errno

import cv2
import numpy as np
import pytest
import torch

from app import cli
from app.console import no_room
from app.console.no_room import no_room_line
from tests.support.cli import razer

MEMORY = "memory ran out: use fewer or smaller frames, larger voxels, or another machine"
FAR_TOO_LARGE = 2**46


def said_by_torch() -> None:
    torch.empty(FAR_TOO_LARGE, dtype=torch.uint8).fill_(1)


def said_by_numpy() -> None:
    np.empty(FAR_TOO_LARGE, np.uint8)


@pytest.mark.parametrize("allocate", [said_by_torch, said_by_numpy])
def test_libraries_are_understood_when_they_have_no_memory(allocate):
    with pytest.raises((RuntimeError, MemoryError)) as raised:
        allocate()
    assert no_room_line(raised.value) == MEMORY


def test_the_interpreter_may_forget_that_it_had_no_memory(monkeypatch):
    forgotten = SystemError("error return without exception set")
    assert no_room_line(forgotten) is None  # there is some: it is an error of the program
    monkeypatch.setattr(no_room, "_SPARE_BYTES", FAR_TOO_LARGE)
    assert no_room_line(forgotten) == MEMORY


def test_why_a_verb_cannot_be_imported_its_cause_says():
    verb = ImportError("Cannot import module 'app.commands.map.track'")
    assert no_room_line(verb) is None
    verb.__cause__ = ImportError("libscipy.so: failed to map segment from shared object")
    assert no_room_line(verb) == MEMORY
    verb.__cause__ = ImportError("No module named 'scipy'")
    assert no_room_line(verb) is None


@pytest.mark.parametrize(
    ("error", "line"),
    [
        (MemoryError(), MEMORY),
        (RuntimeError("std::bad_alloc"), MEMORY),
        (RuntimeError("[Open3D Error] MemoryManagerCPU.cpp:20: CPU malloc failed"), MEMORY),
        (cv2.error("(-4:Insufficient memory) Failed to allocate 800 bytes in function 'OutOfMemoryError'"), MEMORY),
        (RuntimeError("[enforce fail at alloc_cpu.cpp] DefaultCPUAllocator: can't allocate memory: you tried"), MEMORY),
        (torch.cuda.OutOfMemoryError("CUDA out of memory. Tried to allocate 2 GiB"), MEMORY),
        (ImportError("libOpen3D.so: failed to map segment from shared object"), MEMORY),
        (OSError(errno.ENOMEM, "Cannot allocate memory"), MEMORY),
        (RuntimeError("can't start new thread"), "no more threads or processes can be started"),
        (BlockingIOError(errno.EAGAIN, "Resource temporarily unavailable"), "no more threads or processes"),
        (OSError(errno.EMFILE, "Too many open files", "a.png"), "too many files are open: raise the limit (ulimit -n)"),
        (OSError(errno.ENOSPC, "No space left on device", "out"), "out: No space left on device: free some space"),
        (OSError(errno.EROFS, "Read-only file system", "out"), "out: Read-only file system"),
        (PermissionError(errno.EACCES, "Permission denied", "out"), "out: Permission denied"),
        (IsADirectoryError(errno.EISDIR, "Is a directory", "out"), "out: Is a directory"),
    ],
)
def test_each_is_one_line(monkeypatch, capsys, error, line):
    def fail(*_: object, **__: object) -> None:
        raise error

    monkeypatch.setattr(cli, "app", fail)
    code, _, err = razer(capsys, "config")
    assert code == 2
    assert err.startswith(f"razer: {line}")
    assert len(err.splitlines()) == 1


@pytest.mark.parametrize(
    "error",
    [
        RuntimeError("index out of range"),
        PermissionError(errno.EACCES, "no file is named"),
        ValueError(),
        KeyError("a"),
    ],
)
def test_errors_of_the_program_keep_their_traceback(monkeypatch, error):
    def fail(*_: object, **__: object) -> None:
        raise error

    monkeypatch.setattr(cli, "app", fail)
    with pytest.raises(type(error)):
        cli.main(["config"])
