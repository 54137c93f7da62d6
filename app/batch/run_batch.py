"""A batch: scenes handed to an engine, the longest first, and tried again where that may help."""

from __future__ import annotations

from bisect import insort
from collections.abc import Iterator, Mapping
from concurrent.futures import ThreadPoolExecutor
from contextlib import suppress
from dataclasses import dataclass, replace
from time import monotonic, process_time

from rich.console import Console

from app.batch.engine import Engine
from app.batch.estimate import Estimator, RecordingSize
from app.batch.one_scene import UNFINISHED, is_finished
from app.batch.report import BatchReport
from app.batch.scene_task import Needs, Outcome, SceneTask
from app.batch.scenes import Scene
from app.console.progress import show_progress
from app.console.waiting import waiting_for
from app.object_store.place import Place
from app.object_store.staging import sizes
from app.settings.run_config import RunConfig
from razer.errors import BadInput

MAX_ATTEMPTS = 3
_WAIT_S = 1.0
_LISTED_AT_ONCE = 16
_LOOKED_AT = 100  # the longest scenes; were there no bound, the last of a million would be looked at a million times
_REPORT_EVERY_S = 2.0


@dataclass
class _Waiting:
    """A scene that is not done, with what went wrong so far."""

    scene: Scene
    size: RecordingSize
    n_failed: int = 0
    n_short_of_memory: int = 0
    avoid: str = ""


class Batch:
    """The scenes of a batch on an engine. `evaluations` holds what was computed of each map."""

    def __init__(
        self,
        scenes: list[Scene],
        template: SceneTask,
        config: RunConfig,
        engine: Engine,
        estimator: Estimator,
        report: BatchReport,
        console: Console,
    ) -> None:
        """template: the task of any scene, without what is the scene's own; the rest as they are called."""
        self._template, self._engine, self._estimator = template, engine, estimator
        self._report, self._console = report, console
        self.evaluations: dict[str, bytes] = {}
        self._running: dict[str, _Waiting] = {}
        self._written_s = self._begun_s = monotonic()
        self._begun_cpu_s = process_time()
        with waiting_for("looking at the recordings", console):
            found = _sizes([scene for scene in scenes if not self._is_done(scene)], config)
        self._waiting = sorted(found, key=self._shortness)

    def run(self) -> None:
        """Work until every scene is done, or has failed for good. However it ends, the report is written, and nothing
        runs any more."""
        total = len(self._report.scenes)
        n_done = total - len(self._waiting)
        try:
            self._write_report()
            for _ in show_progress(
                self._ended(), total, self._status, self._console, first="the first scene", things="scenes", done=n_done
            ):
                pass
        finally:
            for outcome in self._engine.wait(0.0):
                self._take(outcome)
            self._engine.close()
            for waiting in (*self._running.values(), *self._waiting):
                if (record := self._report.scenes[waiting.scene.name]).status != "done":
                    record.reason = "the batch was ended before"
            _remove_if_empty(self._report.out)
            self._write_report()

    def _is_done(self, scene: Scene) -> bool:
        record = self._report.scenes[scene.name]
        if is_finished(self._out(scene)):
            record.status = "done"
            return not self._template.truth_preset
        record.status = "unfinished"
        return False

    def _out(self, scene: Scene) -> Place:
        return self._report.out / scene.name

    def _ended(self) -> Iterator[str]:
        """The names of scenes that are done or failed, as they end."""
        while self._waiting or self._running:
            self._submit()
            for outcome in self._engine.wait(_WAIT_S):
                if self._take(outcome):
                    yield outcome.task.name
            if monotonic() - self._written_s > _REPORT_EVERY_S:
                self._write_report()

    def _shortness(self, waiting: _Waiting) -> float:
        """By what the longest comes first; what is learnt makes all scenes longer, or all shorter."""
        return -self._estimator.seconds(waiting.size)

    def _submit(self) -> None:
        """Hand over the longest of the scenes for which there is room, as long as there is any."""
        for waiting in self._waiting[:_LOOKED_AT]:
            needs = self._estimator.needs(waiting.size, waiting.n_short_of_memory).within(self._engine.most)
            if not self._engine.has_room(needs):
                continue
            self._waiting.remove(waiting)
            self._running[waiting.scene.name] = waiting
            self._engine.submit(self._task(waiting, needs))

    def _task(self, waiting: _Waiting, needs: Needs) -> SceneTask:
        scene = waiting.scene
        return replace(
            self._template,
            name=scene.name,
            recording=scene.recording.text,
            out=self._out(scene).text,
            needs=needs,
            number=waiting.n_failed + 1,
            avoid=waiting.avoid,
        )

    def _take(self, outcome: Outcome) -> bool:
        """Take in an attempt; returns whether it was the scene's last."""
        name = outcome.task.name
        waiting = self._running.pop(name)
        if outcome.is_done and not is_finished(self._out(waiting.scene)):
            shared = f"{outcome.node} wrote it where this machine does not see it: give a shared folder, or a URI"
            outcome = replace(outcome, reason=shared, remedy="none")
        if outcome.is_done and self._report.scenes[name].status == "done":  # it was there: no map was made
            self._keep_evaluation(outcome)
            return True
        self._report.add(outcome)
        if outcome.is_done:
            if outcome.cpu_s:  # one that was there already teaches nothing
                self._estimator.learn(waiting.size, outcome)
            self._keep_evaluation(outcome)
            return True
        waiting.n_failed += 1
        waiting.n_short_of_memory += outcome.remedy == "memory"
        waiting.avoid = outcome.node_id or waiting.avoid
        is_last = outcome.remedy == "none" or waiting.n_failed >= MAX_ATTEMPTS
        self._tell(outcome, is_last)
        if is_last:
            self._report.scenes[name].status = "failed"
        else:
            insort(self._waiting, waiting, key=self._shortness)
        return is_last

    def _keep_evaluation(self, outcome: Outcome) -> None:
        if outcome.evaluation is not None:
            self.evaluations[outcome.task.name] = outcome.evaluation
        elif outcome.not_evaluated:
            self._console.print(f"{outcome.task.name} is not evaluated: {outcome.not_evaluated}", soft_wrap=True)

    def _tell(self, outcome: Outcome, is_last: bool) -> None:
        what = "failed" if is_last else "is tried again"
        where = f" ({outcome.node})" if outcome.node else ""
        self._console.print(f"{outcome.task.name} {what}: {outcome.reason}{where}", soft_wrap=True)

    def _status(self) -> str:
        failed = sum(record.status == "failed" for record in self._report.scenes.values())
        return f"{len(self._running)} under way" + (f", {failed} failed" if failed else "")

    def _write_report(self) -> None:
        self._written_s = monotonic()
        seconds = {"seconds": self._written_s - self._begun_s, "engine_cpu_s": process_time() - self._begun_cpu_s}
        self._report.totals |= {name: round(value, 2) for name, value in seconds.items()}
        self._report.write()


def _sizes(scenes: list[Scene], config: RunConfig) -> list[_Waiting]:
    """The scenes with what their recordings have; one that cannot be looked at is tried all the same."""
    with ThreadPoolExecutor(_LISTED_AT_ONCE) as pool:
        return [_Waiting(*pair) for pair in zip(scenes, pool.map(lambda one: _size(one, config), scenes), strict=True)]


def _size(scene: Scene, config: RunConfig) -> RecordingSize:
    files: Mapping[str, int]
    try:
        files = sizes(scene.recording)
    except BadInput:
        files = {}
    return RecordingSize.of(files, config)


def _remove_if_empty(out: Place) -> None:
    if not out.is_remote:
        with suppress(OSError):  # runs that go on another time are in it
            (out.path / UNFINISHED).rmdir()
