"""A batch: scenes handed to an engine, with a report of what becomes of them."""

from __future__ import annotations

import os
from collections.abc import Iterator, Mapping
from concurrent.futures import ThreadPoolExecutor
from contextlib import suppress
from dataclasses import dataclass, replace
from time import monotonic, process_time

from rich.console import Console

from app.batch.estimate import Estimator, RecordingSize
from app.batch.one_scene import UNFINISHED, SceneTask, is_finished
from app.batch.report import BatchReport
from app.batch.scenes import LISTED_AT_ONCE, Scene
from app.console.progress import show_progress
from app.console.waiting import waiting_for
from app.engines.child_notes import tell_notes
from app.engines.engine import Engine
from app.engines.task import Needs, Outcome
from app.engines.work_queue import Ended, WorkQueue
from app.object_store.place import Place
from app.object_store.staging import sizes
from app.settings.run_config import RunConfig
from razer.errors import BadInput

_REPORT_EVERY_S = 2.0


class Batch:
    """The scenes of a batch on an engine. `evaluations` holds what was computed of each map, pickled, `not_evaluated`
    why it was not."""

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
        self._template, self._estimator = template, estimator
        self._report, self._console = report, console
        self.evaluations: dict[str, bytes] = {}
        self.not_evaluated: dict[str, str] = {}
        self._written_s = self._begun_s = monotonic()
        self._begun_cpu_s = process_time()
        with waiting_for("looking at the recordings", console):
            left = [scene for scene in scenes if template.truth_preset or not self._is_done(scene.name)]
            works = [self._work(scene, size) for scene, size in zip(left, _sizes(left, config), strict=True)]
        self._queue = WorkQueue(works, engine)

    def run(self) -> None:
        """Work until every scene is done, or has failed for good. However it ends, the report is written, and nothing
        runs any more."""
        total, last = len(self._report.scenes), list[Ended[_SceneWork]]()
        n_done = total - len(self._queue.not_done)
        try:
            self._write_report()
            with self._queue.closed_at_the_end(last):
                for _ in show_progress(
                    self._ended(),
                    total,
                    self._status,
                    self._console,
                    first="the first scene",
                    things="scenes",
                    done=n_done,
                ):
                    pass
        finally:
            for ended in last:
                self._take(ended)
            for work in self._queue.not_done:
                if not self._is_done(work.name):
                    self._report.scenes[work.name].reason = "the batch was ended before"
            _remove_if_empty(self._report.out)
            self._write_report()

    def _is_done(self, name: str) -> bool:
        return self._report.scenes[name].status == "done"

    def _work(self, scene: Scene, size: RecordingSize) -> _SceneWork:
        out = self._report.out / scene.name
        template = replace(self._template, name=scene.name, recording=scene.recording.text, out=out.text)
        return _SceneWork(template, size, self._estimator, out)

    def _ended(self) -> Iterator[str]:
        """The names of scenes that are done or failed, as they end."""
        for several in self._queue.work():
            for ended in several:
                self._take(ended)
                if ended.is_last:
                    yield ended.work.name
            if monotonic() - self._written_s > _REPORT_EVERY_S:
                self._write_report()

    def _take(self, ended: Ended[_SceneWork]) -> None:
        """Take in an attempt."""
        outcome, name = ended.outcome, ended.work.name
        if outcome.is_done:
            self._keep_evaluation(outcome)
            if self._is_done(name):  # it was there: no map was made
                return
            if outcome.cpu_s:  # one that was there already teaches nothing
                self._estimator.learn(ended.work.size, outcome)
        else:
            self._tell(outcome, ended.is_last)
        self._report.add(outcome)
        if ended.is_last and not outcome.is_done:
            self._report.scenes[name].status = "failed"

    def _keep_evaluation(self, outcome: Outcome) -> None:
        tell_notes(outcome.name, outcome.notes)
        if outcome.result is not None:
            self.evaluations[outcome.name] = outcome.result
        elif outcome.no_result:
            self.not_evaluated[outcome.name] = outcome.no_result
            self._console.print(f"{outcome.name} is not evaluated: {outcome.no_result}", soft_wrap=True)

    def _tell(self, outcome: Outcome, is_last: bool) -> None:
        what = "failed" if is_last else "is tried again"
        where = f" ({outcome.node})" if outcome.node else ""
        self._console.print(f"{outcome.name} {what}: {outcome.reason}{where}", soft_wrap=True)

    def _status(self) -> str:
        failed = sum(record.status == "failed" for record in self._report.scenes.values())
        return f"{self._queue.n_running} under way" + (f", {failed} failed" if failed else "")

    def _write_report(self) -> None:
        self._written_s = monotonic()
        seconds = {"seconds": self._written_s - self._begun_s, "engine_cpu_s": process_time() - self._begun_cpu_s}
        self._report.totals |= {name: round(value, 2) for name, value in seconds.items()}
        self._report.write()


@dataclass(frozen=True)
class _SceneWork:
    """A scene that is not done, see `Work`. template: its task, without what is an attempt's own."""

    template: SceneTask
    size: RecordingSize
    estimator: Estimator
    out: Place

    @property
    def name(self) -> str:
        return self.template.name

    @property
    def seconds(self) -> float:
        return self.estimator.seconds(self.size)

    def needs(self, n_short_of_memory: int) -> Needs:
        return self.estimator.needs(self.size, n_short_of_memory)

    def task(self, needs: Needs, number: int, avoid: str) -> SceneTask:
        return replace(self.template, needs=needs, number=number, avoid=avoid)

    def checked(self, outcome: Outcome) -> Outcome:
        """A map that is not seen from here is none."""
        if outcome.is_done and not is_finished(self.out):
            shared = f"{outcome.node} wrote it where this machine does not see it: give a shared folder, or a URI"
            return replace(outcome, reason=shared, remedy="none")
        return outcome


def maps_there(scenes: list[Scene], out: Place) -> dict[str, bool]:
    """By name, whether the map of a scene is in `out`; raises BadInput where something else is in its place."""
    with ThreadPoolExecutor(LISTED_AT_ONCE) as pool:
        found = dict(
            zip([one.name for one in scenes], pool.map(lambda one: is_finished(out / one.name), scenes), strict=True)
        )
    for name, is_there in found.items():
        if not is_there and not out.is_remote and os.path.lexists(out.path / name):
            raise BadInput(f"{out / name} is in the way, and no run: choose another place with -o")
    return found


def _sizes(scenes: list[Scene], config: RunConfig) -> list[RecordingSize]:
    """What the recordings of scenes have; one that cannot be looked at is tried all the same."""
    with ThreadPoolExecutor(LISTED_AT_ONCE) as pool:
        return list(pool.map(lambda one: _size(one, config), scenes))


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
