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
from app.run_folder.run_folder import TIMINGS, RunFolder
from razer.errors import BadInput
from razer.files import read_json
from razer.storage.file_names import is_map_folder

UNFINISHED = ".unfinished"  # in OUT: runs that go on, and those that were cut off
_LOG_BYTES = 64_000
_MEMORY_WORDS = ("memory ran out", "perhaps as memory ran out", "helper process was ended by the system")
_NO_ROOM_WORDS = ("No space left", "free some space", "Disk quota")
_NOTHING_TO_DO = ChildEnd(0, 0.0, 0.0)
_GIVEN_UP = "given up, as the batch was ended"
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
        out, source = Place(self.task.out), Place(self.task.recording)
        if is_finished(out):  # by an earlier batch, or an attempt that was taken for lost
            return self._evaluated(Outcome(self.task), source, out, scratch)
        recording, run = staged(source), unfinished_folder(out)
        run.parent.mkdir(parents=True, exist_ok=True)
        end, log = (_NOTHING_TO_DO, "") if _is_whole(run) else self._map(recording, run, scratch)
        outcome = Outcome(self.task, cpu_s=end.cpu_s, peak_mb=end.peak_mb, log=log)
        if problem := _problem(end, log, run):
            shutil.rmtree(run, ignore_errors=True)  # of a run that ended early, half a map
            return replace(outcome, reason=problem[0], remedy=problem[1])
        outcome = self._evaluated(outcome, Place(str(recording)), Place(str(run)), scratch)
        if self.stop.is_set():  # the map waits there for another time
            return replace(outcome, reason=_GIVEN_UP, remedy="elsewhere")
        _deliver(run, out)
        forget(source)
        return outcome

    def _evaluated(self, outcome: Outcome, recording: Place, run: Place, scratch: Path) -> Outcome:
        """With the evaluation of its map, where one is asked for; that there can be none harms no map."""
        if not self.task.truth_preset:
            return outcome
        log, result = scratch / "evaluation-log", scratch / "evaluation"
        trust = [word for word in self.task.words if word == "--trust-plugins"]
        folders = [str(staged(run)), str(staged(recording))]
        command = [sys.executable, "-m", "app.batch.scene_evaluation", self.task.name, *folders]
        command += [self.task.truth_preset, str(result), *trust]
        end = self._run(command, log, scratch)
        if end.code == 0:
            return replace(outcome, evaluation=result.read_bytes(), cpu_s=outcome.cpu_s + end.cpu_s)
        said = log.read_text(encoding="utf-8", errors="replace")
        return replace(outcome, not_evaluated=_last_words(said), log=outcome.log + said[-_LOG_BYTES:])

    def _map(self, recording: Path, run: Path, scratch: Path) -> tuple[ChildEnd, str]:
        log = scratch / "log"
        end = self._run(self._command(recording, run, scratch), log, scratch)
        return end, log.read_bytes()[-_LOG_BYTES:].decode(errors="replace")

    def _run(self, command: list[str], log: Path, scratch: Path) -> ChildEnd:
        threads = (self.task.cores or int(self.task.needs.cpus)) - HELPERS
        return run_child(
            command,
            log,
            scratch / "out",
            folder=self.task.working_folder,
            cores=self.task.cores,
            threads=max(1, threads),
            stop=self.stop,
        )

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


def _is_whole(run: Path) -> bool:
    """Whether a run was finished, and not ended early, by a batch that was ended before it took the map away."""
    if not is_map_folder(run) or not (run / TIMINGS).is_file():
        return False
    timings = read_json(run / TIMINGS, only_finite=False)
    return isinstance(timings, dict) and timings.get("interrupted") is False


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
        return _GIVEN_UP, "elsewhere"
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
