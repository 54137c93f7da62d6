"""One attempt at one scene, on whatever machine: staged, mapped by `razer run` in a process of its own, published."""

from __future__ import annotations

import shutil
import socket
import sys
import traceback
from dataclasses import dataclass, replace
from glob import escape
from pathlib import Path
from tempfile import TemporaryDirectory
from threading import Event
from time import monotonic
from typing import TypedDict

from app.batch.scene_evaluation import evaluated_scene
from app.engines.called_function import LOG_BYTES, Call
from app.engines.child_failure import GIVEN_UP, failure, last_words
from app.engines.child_notes import notes_of
from app.engines.child_process import ChildEnd, run_child
from app.engines.task import Needs, Outcome, Remedy
from app.object_store.place import Place
from app.object_store.publishing import is_published, publish
from app.object_store.staging import forget, staged, staging_folder
from app.profiling.cores import HELPERS
from app.run_folder.run_folder import TIMINGS, RunFolder
from razer.errors import BadInput
from razer.files import read_json
from razer.storage.file_names import is_map_folder

UNFINISHED = ".unfinished"  # in OUT: runs that go on, and those that were cut off
_NOTHING_TO_DO = ChildEnd(0, 0.0, 0.0)


@dataclass(frozen=True)
class SceneTask:
    """One attempt at one scene, see `Task`.

    name: of the scene. recording, out: path or URI of the recording and of the run folder to be made. words: options of
    `razer run`. config: content of a --config file, None = none. working_folder: what relative paths of the options are
    relative to. needs: what is kept free for it. cores: to how many cores it is held, 0 = to none. number: of the
    attempt, from 1. avoid: node that failed it before, "" = none. truth_preset: by whose rules the map is evaluated,
    "" = not at all.
    """

    name: str
    recording: str
    out: str
    words: tuple[str, ...]
    needs: Needs
    working_folder: str
    config: str | None = None
    cores: int = 0
    number: int = 1
    avoid: str = ""
    truth_preset: str = ""

    def run(self, stop: Event) -> Outcome:
        """Map the scene. When `stop` is set it is given up, and goes on from its checkpoint another time."""
        begun_s = monotonic()
        attempt = _Attempt(self, stop)
        try:
            with TemporaryDirectory(prefix="razer-batch-") as folder:
                outcome = attempt.make(Path(folder))
        except BadInput as error:
            outcome = replace(attempt.nothing, reason=str(error), remedy="elsewhere")
        except Exception as error:  # one scene's, not the batch's
            why, log = f"{type(error).__name__}: {error}", traceback.format_exc()
            outcome = replace(attempt.nothing, reason=why, remedy="elsewhere", log=log)
        return replace(outcome, seconds=monotonic() - begun_s, node=socket.gethostname())


def is_finished(out: Place) -> bool:
    """Whether the run folder of a scene is there, whole."""
    return is_published(out) if out.is_remote else is_map_folder(out.path)


def unfinished_folder(out: Place) -> Path:
    """Where a scene's run is made: beside its place, or, where that is in a store, on this machine."""
    if out.is_remote:
        return staging_folder("outputs", out) / out.name
    return out.path.parent / UNFINISHED / out.name


class _Bounds(TypedDict):
    """What a child process is held to, and what ends it."""

    cores: int
    threads: int
    stop: Event


@dataclass
class _Attempt:
    task: SceneTask
    stop: Event

    @property
    def nothing(self) -> Outcome:
        """What is answered where nothing was done."""
        return Outcome(self.task.name)

    def make(self, scratch: Path) -> Outcome:
        """Stage, map, evaluate, publish."""
        out, source = Place(self.task.out), Place(self.task.recording)
        if is_finished(out):  # by an earlier batch, or an attempt that was taken for lost
            return self._evaluated(self.nothing, source, out, scratch)
        recording, run = staged(source), unfinished_folder(out)
        run.parent.mkdir(parents=True, exist_ok=True)
        end, log = (_NOTHING_TO_DO, "") if _is_whole(run) else self._map(recording, run, scratch)
        outcome = replace(self.nothing, cpu_s=end.cpu_s, peak_mb=end.peak_mb, log=log)
        if problem := _problem(end, log, run):
            shutil.rmtree(run, ignore_errors=True)  # of a run that ended early, half a map
            return replace(outcome, reason=problem[0], remedy=problem[1])
        outcome = self._evaluated(outcome, Place(str(recording)), Place(str(run)), scratch)
        if self.stop.is_set():  # the map waits there for another time
            return replace(outcome, reason=GIVEN_UP, remedy="elsewhere")
        _deliver(run, out)
        forget(source)
        return outcome

    def _evaluated(self, outcome: Outcome, recording: Place, run: Place, scratch: Path) -> Outcome:
        """With the evaluation of its map, where one is asked for; that there can be none harms no map."""
        if not self.task.truth_preset:
            return outcome
        folders = (str(staged(run)), str(staged(recording)))
        trusts = "--trust-plugins" in self.task.words
        call = Call(evaluated_scene, (self.task.name, *folders, self.task.truth_preset, trusts))
        end, said, result = call.run(scratch, folder=self.task.working_folder, **self._bounds)
        outcome = replace(outcome, cpu_s=outcome.cpu_s + end.cpu_s, log=outcome.log + said, notes=notes_of(said))
        return replace(outcome, result=result, no_result="" if result is not None else last_words(said))

    def _map(self, recording: Path, run: Path, scratch: Path) -> tuple[ChildEnd, str]:
        log, command = scratch / "log", self._command(recording, run, scratch)
        end = run_child(command, log, scratch / "out", folder=self.task.working_folder, **self._bounds)
        return end, log.read_bytes()[-LOG_BYTES:].decode(errors="replace")

    @property
    def _bounds(self) -> _Bounds:
        threads = (self.task.cores or int(self.task.needs.cpus)) - HELPERS
        return {"cores": self.task.cores, "threads": max(1, threads), "stop": self.stop}

    def _command(self, recording: Path, run: Path, scratch: Path) -> list[str]:
        """`razer run`, on from its checkpoint where there is one."""
        program = [sys.executable, "-m", "app", "run"]
        if _has_checkpoint(run):
            return [*program, "--resume", str(run), *[word for word in self.task.words if word == "--trust-plugins"]]
        for leftover in run.parent.glob(f".{escape(run.name)}.partial-*"):
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
    if end.code == 0 and not is_map_folder(run):
        return "the run ended without a map", "elsewhere"
    return failure(end, log)


def _deliver(run: Path, out: Place) -> None:
    """Give the finished run its place, at once."""
    if out.is_remote:
        publish(run, out)
        shutil.rmtree(run.parent, ignore_errors=True)
    else:
        run.rename(out.path)
