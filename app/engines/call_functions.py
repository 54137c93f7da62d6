"""Many calls of functions on an engine."""

from __future__ import annotations

import pickle
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from rich.console import Console

from app.console.progress import show_progress
from app.engines.called_function import Call, CallTask
from app.engines.child_notes import tell_notes
from app.engines.engine import Engine
from app.engines.task import Needs, Outcome
from app.engines.work_queue import Ended, WorkQueue
from razer.errors import BadInput

_MARGIN, _MORE = 1.2, 2.0  # of memory, over what other calls took; and once it ran out


class CallFailed(Exception):
    """A call ended in an error that is nobody's input's; what it said, with its traceback."""


@dataclass(frozen=True)
class NamedCall:
    """A call, what it is called, and what it needs and takes, of which the memory is corrected by those that ended."""

    name: str
    call: Call
    needs: Needs
    seconds: float = 1.0


def call_functions(calls: Sequence[NamedCall], engine: Engine, console: Console, *, things: str) -> dict[str, Any]:
    """The results by name, in the order of the calls.

    Args:
        calls: each of a name of its own.
        engine: closed at the end.
        console: where progress is shown.
        things: what the calls are, such as "scenes".

    Raises:
        BadInput: of the first that says so, or had no room in memory or on a disk; no other is waited for.
        CallFailed: of the first that failed otherwise, for good.
    """
    memory = _Memory()
    queue = WorkQueue([_CallWork(one, memory, str(Path.cwd())) for one in calls], engine)
    results: dict[str, Any] = {}
    with queue.closed_at_the_end([]):
        for _ in show_progress(
            _results(queue, results, console),
            len(calls),
            lambda: f"{queue.n_running} under way",
            console,
            first=f"the first of the {things}",
            things=things,
        ):
            pass
    return {one.name: results[one.name] for one in calls}


def _results(queue: WorkQueue[_CallWork], results: dict[str, Any], console: Console) -> Iterator[str]:
    """Fill `results`; gives their names as they come."""
    for several in queue.work():
        for ended in several:
            outcome = ended.outcome
            if ended.is_last:
                tell_notes(outcome.name, outcome.notes)
            _raise_if_failed(ended)
            if not outcome.is_done:
                console.print(f"{outcome.name} is tried again: {outcome.reason}", soft_wrap=True)
                continue
            assert outcome.result is not None
            ended.work.memory.seen_mb.append(outcome.peak_mb)
            results[outcome.name] = pickle.loads(outcome.result)
            yield outcome.name


def _raise_if_failed(ended: Ended[_CallWork]) -> None:
    outcome = ended.outcome
    if outcome.is_done or not ended.is_last:
        return
    if outcome.remedy == "none":
        raise BadInput(outcome.reason)
    if outcome.remedy != "elsewhere":
        raise BadInput(f"{outcome.name}: {outcome.reason}")
    raise CallFailed(f"{outcome.name}: {outcome.reason}\n{outcome.log}")


@dataclass
class _Memory:
    seen_mb: list[float] = field(default_factory=list)


@dataclass(frozen=True)
class _CallWork:
    """See `Work`."""

    of: NamedCall
    memory: _Memory
    working_folder: str

    @property
    def name(self) -> str:
        return self.of.name

    @property
    def seconds(self) -> float:
        return self.of.seconds

    def needs(self, n_short_of_memory: int) -> Needs:
        seen_mb = self.memory.seen_mb
        memory_mb = _MARGIN * max(seen_mb) if seen_mb else self.of.needs.memory_mb
        return Needs(self.of.needs.cpus, memory_mb * _MORE**n_short_of_memory, self.of.needs.gpus)

    def task(self, needs: Needs, number: int, avoid: str) -> CallTask:
        return CallTask(self.name, self.of.call, needs, self.working_folder, number, avoid)

    def checked(self, outcome: Outcome) -> Outcome:
        return outcome
