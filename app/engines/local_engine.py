"""The engine of one machine: as many tasks at once as its cores and its memory hold."""

from __future__ import annotations

import os
from concurrent.futures import FIRST_COMPLETED, Future, ThreadPoolExecutor, wait
from pathlib import Path
from threading import Event

import psutil

from app.engines.task import Needs, Outcome, Task

_SPARE = 0.05  # of the free memory, for everything else on the machine
_CGROUP = Path("/sys/fs/cgroup/memory.max")


class LocalEngine:
    """Each task is waited for by a thread, and done by processes. One runs in any case, however much it needs."""

    def __init__(self, workers: int | None = None) -> None:
        """workers: how many tasks at once, whatever CPUs they ask for; None: as many as these allow."""
        self._workers = workers
        self._total = Needs(len(os.sched_getaffinity(0)), free_memory_mb() * (1 - _SPARE), n_gpus())
        self._running: dict[Future[Outcome], Needs] = {}
        self._stop = Event()
        self._pool = ThreadPoolExecutor(workers or max(1, int(self._total.cpus)), thread_name_prefix="task")

    @property
    def most(self) -> Needs:
        """The whole machine."""
        return self._total

    def has_room(self, needs: Needs) -> bool:
        """Whether cores, or workers, and memory are left for it."""
        taken = self._running.values()
        if not taken:
            return True
        if sum(one.memory_mb for one in taken) + needs.memory_mb > self._total.memory_mb:
            return False
        if needs.gpus and sum(one.gpus for one in taken) + needs.gpus > self._total.gpus:
            return False
        if self._workers is not None:
            return len(taken) < self._workers
        return sum(one.cpus for one in taken) + needs.cpus <= self._total.cpus

    def submit(self, task: Task) -> None:
        """Begin with it."""
        self._running[self._pool.submit(task.run, self._stop)] = task.needs

    def wait(self, timeout_s: float) -> list[Outcome]:
        """The attempts that ended."""
        done, _ = wait(self._running, timeout_s, FIRST_COMPLETED)
        for future in done:
            del self._running[future]
        return [future.result() for future in done if not future.cancelled()]

    def close(self) -> None:
        """End all tasks, with their processes."""
        self._stop.set()
        self._pool.shutdown(wait=True, cancel_futures=True)


def free_memory_mb() -> float:
    """Memory that programs may still take, in 10^6 bytes, within the bounds of a container."""
    free = psutil.virtual_memory().available
    if _CGROUP.exists() and (text := _CGROUP.read_text().strip()).isdigit():
        free = min(free, int(text))
    return free / 1e6


def n_gpus() -> float:
    """How many GPUs of NVIDIA the system has; counted by its devices, as CUDA itself takes seconds to load."""
    return float(len(list(Path("/dev").glob("nvidia[0-9]*"))))
