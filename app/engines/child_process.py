"""One child process: started, measured and, where it has to be, ended with all its helpers."""

from __future__ import annotations

import os
import resource
import select
import signal
import subprocess
import sys
from collections.abc import Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path
from threading import Event

_LAUNCH = Path(__file__).with_name("held_launch.py")
_ROOT = Path(__file__).resolve().parents[2]
_SAMPLE_MS = 500
_PAGE_MB = os.sysconf("SC_PAGE_SIZE") / 1e6


@dataclass(frozen=True)
class ChildEnd:
    """code: exit code, negative for a signal; None where it was ended by us. cpu_s: processor time of it and of the
    helpers it waited for; peak_mb: the most that all of them had in memory at once, sampled."""

    code: int | None
    cpu_s: float
    peak_mb: float


def run_child(
    command: Sequence[str], log: Path, out: Path, *, folder: str, cores: int, threads: int, stop: Event
) -> ChildEnd:
    """Run a command to its end, standard output into the file `out`, standard error added to `log`; when `stop` is set
    it is killed, with its helpers: its checkpoint is what it goes on from.

    Args:
        command: with the full path of the program first.
        log: what it says.
        out: what it answers.
        folder: where it works.
        cores: how many it is held to, 0 = none.
        threads: of Open3D, in its first process.
        stop: whether to end it.
    """
    held = [sys.executable, "-S", str(_LAUNCH), str(os.getpid()), str(cores), *command]
    with out.open("wb") as answers, log.open("ab") as said:
        process = subprocess.Popen(
            held,
            stdin=subprocess.DEVNULL,
            stdout=answers,
            stderr=said,
            cwd=folder if Path(folder).is_dir() else None,
            env=_environment(threads),
            start_new_session=True,  # a Ctrl-C is the batch's: a run would end early, with half a map
        )
        return _watched(process, stop)


def _environment(threads: int) -> Mapping[str, str]:
    """Ours, in which our own code is found, with threads as many as there are cores for them: workers of a cluster come
    with a number of their own."""
    paths = [str(_ROOT), *filter(None, [os.environ.get("PYTHONPATH")])]
    return {**os.environ, "PYTHONPATH": os.pathsep.join(paths), "OMP_NUM_THREADS": str(threads)}


def _watched(process: subprocess.Popen[bytes], stop: Event) -> ChildEnd:
    peak_mb = 0.0
    try:
        ended = select.poll()
        descriptor = os.pidfd_open(process.pid)
        ended.register(descriptor, select.POLLIN)
        try:
            while not ended.poll(_SAMPLE_MS) and not stop.is_set():
                peak_mb = max(peak_mb, tree_mb(process.pid))
        finally:
            os.close(descriptor)
    finally:
        with suppress(ProcessLookupError):
            os.killpg(process.pid, signal.SIGKILL)  # helpers of a run that was killed, too
    _, status, usage = os.wait4(process.pid, 0)
    process.returncode = os.waitstatus_to_exitcode(status)
    code = None if stop.is_set() else process.returncode
    # A process that was forked has the peak of the one it came from until its own is larger.
    if usage.ru_maxrss > resource.getrusage(resource.RUSAGE_SELF).ru_maxrss:
        peak_mb = max(peak_mb, usage.ru_maxrss * 1024 / 1e6)
    return ChildEnd(code, usage.ru_utime + usage.ru_stime, peak_mb)


def tree_mb(pid: int) -> float:
    """Resident memory of a process and of those below it, in 10^6 bytes; what they share is counted once."""
    own, shared = 0.0, 0.0
    for member in _tree(pid):
        with suppress(OSError, ValueError):
            _, resident, common, *_ = map(int, Path(f"/proc/{member}/statm").read_text().split())
            own += (resident - common) * _PAGE_MB
            shared = max(shared, common * _PAGE_MB)
    return own + shared


def _tree(pid: int) -> list[int]:
    members = [pid]
    for member in members:
        with suppress(OSError):
            for tasks in Path(f"/proc/{member}/task").iterdir():
                members.extend(int(child) for child in (tasks / "children").read_text().split())
    return members
