"""One attempt at one scene, on whatever machine: staged, mapped by `razer run` in a process of its own, published."""

from __future__ import annotations

import shutil
import socket
import sys
import traceback
from dataclasses import dataclass, replace
from pathlib import Path
from tempfile import TemporaryDirectory
from threading import Event
from time import monotonic

from app.batch.child_process import ChildEnd, run_child
from app.batch.scene_task import Outcome, Remedy, SceneTask
from app.object_store.place import Place
from app.object_store.publishing import is_published, publish
from app.object_store.staging import forget, staged, staging_folder
from app.profiling.cores import HELPERS
from app.run_folder.run_folder import RunFolder
from razer.errors import BadInput
from razer.storage.file_names import is_map_folder

UNFINISHED = ".unfinished"  # in OUT: runs that go on, and those that were cut off
_LOG_BYTES = 64_000
_MEMORY_WORDS = ("memory ran out", "perhaps as memory ran out", "helper process was ended by the system")
_NO_ROOM_WORDS = ("No space left", "free some space", "Disk quota")
_INTERRUPTED = "the run was told to end by a signal from elsewhere"


def run_scene(task: SceneTask, stop: Event | None = None) -> Outcome:
    """Map a scene; what goes wrong is told in the outcome. When `stop` is set it is given up, and goes on from its
    checkpoint another time."""
    begun_s = monotonic()
    attempt = _Attempt(task, stop or Event())
    try:
        with TemporaryDirectory(prefix="razer-batch-") as folder:
            outcome = attempt.make(Path(folder))
    except BadInput as error:
        outcome = Outcome(task, str(error), "elsewhere")
    except Exception as error:  # one scene's, not the batch's
        outcome = Outcome(task, f"{type(error).__name__}: {error}", "elsewhere", log=traceback.format_exc())
    return replace(outcome, seconds=monotonic() - begun_s, node=socket.gethostname())


def is_finished(out: Place) -> bool:
    """Whether the run folder of a scene is there, whole."""
    return is_published(out) if out.is_remote else is_map_folder(out.path)


def unfinished_folder(out: Place) -> Path:
    """Where a scene's run is made: beside its place, or, where that is in a store, on this machine."""
    if out.is_remote:
        return staging_folder("outputs", out) / out.name
    return out.path.parent / UNFINISHED / out.name


@dataclass
class _Attempt:
    task: SceneTask
    stop: Event

    def make(self, scratch: Path) -> Outcome:
        """Stage, map, evaluate, publish."""
        out = Place(self.task.out)
        if is_finished(out):  # by an attempt that was taken for lost
            return Outcome(self.task)
        recording, run = staged(Place(self.task.recording)), unfinished_folder(out)
        run.parent.mkdir(parents=True, exist_ok=True)
        end, log = self._map(recording, run, scratch)
        outcome = Outcome(self.task, cpu_s=end.cpu_s, peak_mb=end.peak_mb, log=log)
        if problem := _problem(end, log, run):
            shutil.rmtree(run, ignore_errors=True)  # of a run that ended early, half a map
            return replace(outcome, reason=problem[0], remedy=problem[1])
        _deliver(run, out)
        forget(Place(self.task.recording))
        return outcome

    def _map(self, recording: Path, run: Path, scratch: Path) -> tuple[ChildEnd, str]:
        log, threads = scratch / "log", (self.task.cores or int(self.task.needs.cpus)) - HELPERS
        end = run_child(
            self._command(recording, run, scratch),
            log,
            scratch / "out",
            folder=self.task.working_folder,
            cores=self.task.cores,
            threads=max(1, threads),
            stop=self.stop,
        )
        return end, log.read_bytes()[-_LOG_BYTES:].decode(errors="replace")

    def _command(self, recording: Path, run: Path, scratch: Path) -> list[str]:
        """`razer run`, on from its checkpoint where there is one."""
        program = [sys.executable, "-m", "app", "run"]
        if _has_checkpoint(run):
            return [*program, "--resume", str(run), *[word for word in self.task.words if word == "--trust-plugins"]]
        for leftover in run.parent.glob(f".{run.name}.partial-*"):
            shutil.rmtree(leftover, ignore_errors=True)
        words = list(self.task.words)
        if self.task.config is not None:
            (scratch / "config.toml").write_text(self.task.config, encoding="utf-8")
            words.append(f"--config={scratch / 'config.toml'}")
        return [*program, str(recording), "-o", str(run), "--overwrite", *words]


def _has_checkpoint(run: Path) -> bool:
    try:
        return RunFolder.unfinished(run).is_resumable
    except BadInput:
        return False


def _problem(end: ChildEnd, log: str, run: Path) -> tuple[str, Remedy] | None:
    """Why a run has no result, and what would help; None where it has one."""
    if end.code == 0:
        return None if is_map_folder(run) else ("the run ended without a map", "elsewhere")
    last = _last_words(log)
    if end.code is None:
        return "given up, as the batch was ended", "elsewhere"
    if end.code == -9:
        return "killed by the system, most often as memory ran out", "memory"
    if any(words in log[-2000:] for words in _MEMORY_WORDS):
        return last, "memory"
    if end.code in (130, 143):
        return _INTERRUPTED, "elsewhere"
    if end.code == 2 and not any(words in last for words in _NO_ROOM_WORDS):
        return last, "none"
    return (f"ended by signal {-end.code}" if end.code < 0 else f"exit code {end.code}: {last}"), "elsewhere"


def _last_words(log: str) -> str:
    """The line that says what went wrong: the last one, without the program's name before it."""
    lines = [line.strip() for line in log.splitlines() if line.strip()]
    marked = [line for line in lines if line.startswith(("razer: ", "WARNING: "))]
    return (marked or lines or ["it said nothing"])[-1].removeprefix("razer: ")


def _deliver(run: Path, out: Place) -> None:
    """Give the finished run its place, at once."""
    if out.is_remote:
        publish(run, out)
        shutil.rmtree(run.parent, ignore_errors=True)
    else:
        run.rename(out.path)
