"""Tests against mutants in forks of one process with the heavy libraries loaded, as loading takes longer than tests."""

from __future__ import annotations

import gc
import importlib.util
import os
import signal
import sys
import time
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from importlib import import_module
from importlib.machinery import ModuleSpec, SourceFileLoader
from pathlib import Path
from types import CodeType, ModuleType

from tests.mutation.mutants import Mutant

HEAVY = ("torch", "open3d", "gtsam", "cv2", "rtree", "scipy.optimize", "scipy.spatial", "pydantic", "hypothesis")
# Nobody reads what a failure prints, and what plug-ins load takes longer than most tests.
PYTEST_OPTIONS = (
    "-x", "-q", "--assert=plain", "-m", "not full", "-p", "no:cacheprovider", "-o", "addopts=--import-mode=importlib",
)  # fmt: skip
TIMED_OUT = -1


@dataclass(frozen=True)
class Job:
    """The test files to run against a mutant, or against the code as it is where there is none."""

    mutant: Mutant | None
    tests: Sequence[str]
    limit_s: float


def warm_up() -> None:
    """Load what takes long; nothing that is mutated, and nothing that starts threads, which no fork takes along."""
    os.environ |= {"OMP_NUM_THREADS": "1", "PYTEST_DISABLE_PLUGIN_AUTOLOAD": "1"}
    for name in (*HEAVY, "pytest"):
        import_module(name)
    assert not any(name.split(".")[0] in ("razer", "slam") for name in sys.modules)
    gc.freeze()  # forks leave alone what they share


def run_all(jobs: Sequence[Job], n_at_once: int) -> Iterator[tuple[Job, int, float]]:
    """Each job with pytest's exit code, 0 where all tests passed, and seconds; `TIMED_OUT` beyond its limit."""
    waiting, running = list(reversed(jobs)), {}
    while waiting or running:
        while waiting and len(running) < n_at_once:
            job = waiting.pop()
            running[_fork(job)] = (job, time.monotonic())
        for process, (job, start) in list(running.items()):
            seconds = time.monotonic() - start
            done, status = os.waitpid(process, os.WNOHANG)
            if not done and seconds > job.limit_s:
                os.killpg(process, signal.SIGKILL)
                os.waitpid(process, 0)
            if done or seconds > job.limit_s:
                del running[process]
                yield job, os.waitstatus_to_exitcode(status) if done else TIMED_OUT, seconds
        time.sleep(0.02)


def _fork(job: Job) -> int:
    process = os.fork()
    if process:
        return process
    code = 3
    try:
        os.setsid()
        silence = os.open(os.devnull, os.O_RDWR)
        for stream in (0, 1, 2):
            os.dup2(silence, stream)
        code = _run_tests(job)
    finally:
        os._exit(code)


def _run_tests(job: Job) -> int:
    import hypothesis
    import pytest
    import torch

    torch.set_num_threads(1)
    # The same examples each time, none of them kept, and no search for the smallest that fails.
    phases = (hypothesis.Phase.explicit, hypothesis.Phase.generate)
    hypothesis.settings.register_profile("mutants", derandomize=True, database=None, deadline=None, phases=phases)
    hypothesis.settings.load_profile("mutants")
    if job.mutant:
        sys.meta_path.insert(0, MutantFinder(job.mutant))
    return int(pytest.main([*PYTEST_OPTIONS, *job.tests]))


class MutantFinder:
    """Finds the one module that is mutated."""

    def __init__(self, mutant: Mutant) -> None:
        self.mutant = mutant
        self.name = mutant.path.removesuffix(".py").replace("/", ".")

    def find_spec(self, name: str, path: object = None, target: ModuleType | None = None) -> ModuleSpec | None:
        if name != self.name:
            return None
        file = str(Path(self.mutant.path).resolve())
        return importlib.util.spec_from_file_location(name, file, loader=_MutantLoader(name, file, self.mutant.source))


class _MutantLoader(SourceFileLoader):
    def __init__(self, name: str, path: str, source: str) -> None:
        super().__init__(name, path)
        self.source = source

    def get_code(self, fullname: str) -> CodeType:
        return compile(self.source, self.path, "exec", dont_inherit=True)
