"""Work handed to an engine, the longest first, and tried again where that may help."""

from __future__ import annotations

from bisect import insort
from collections import Counter
from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from typing import Generic, Protocol, TypeVar

from app.engines.engine import Engine
from app.engines.task import Needs, Outcome, Task

MAX_ATTEMPTS = 3
_WAIT_S = 1.0
_LOOKED_AT = 100  # the longest pieces; were there no bound, the last of a million would be looked at a million times


class Work(Protocol):
    """A piece of work, of which tasks are made."""

    @property
    def name(self) -> str:
        """Unlike that of all others."""

    @property
    def seconds(self) -> float:
        """How long it will take; what is learnt meanwhile makes all longer, or all shorter."""

    def needs(self, n_short_of_memory: int) -> Needs:
        """What it asks for, once memory ran out so many times."""

    def task(self, needs: Needs, number: int, avoid: str) -> Task:
        """An attempt at it."""

    def checked(self, outcome: Outcome) -> Outcome:
        """What became of an attempt, as it looks from here."""


W = TypeVar("W", bound=Work)


@dataclass
class _Waiting(Generic[W]):
    """Work that is not done, with what went wrong so far."""

    work: W
    n_failed: int = 0
    n_short_of_memory: int = 0
    avoid: str = ""


@dataclass(frozen=True)
class Ended(Generic[W]):
    """An attempt that ended, and whether it was the last at its work."""

    work: W
    outcome: Outcome
    is_last: bool


class WorkQueue(Generic[W]):
    """Pieces of work on an engine, which is the queue's own."""

    def __init__(self, works: Iterable[W], engine: Engine) -> None:
        """Sort them; raises ValueError where two have one name, by which outcomes are told apart."""
        self._engine = engine
        self._waiting = sorted((_Waiting(work) for work in works), key=_shortness)
        counts = Counter(waiting.work.name for waiting in self._waiting)
        if twice := [name for name, count in counts.items() if count > 1]:
            raise ValueError(f"{counts[twice[0]]} pieces of work are called {twice[0]}")
        self._running: dict[str, _Waiting[W]] = {}

    @property
    def n_running(self) -> int:
        """How many tasks are handed over."""
        return len(self._running)

    @property
    def not_done(self) -> list[W]:
        """What is under way, and what waits."""
        return [waiting.work for waiting in (*self._running.values(), *self._waiting)]

    def work(self) -> Iterator[list[Ended[W]]]:
        """Work until everything is done, or has failed for good; gives the attempts that ended, once a second at least,
        and then perhaps none."""
        while self._waiting or self._running:
            self._submit()
            yield self._taken(_WAIT_S)

    @contextmanager
    def closed_at_the_end(self, last: list[Ended[W]]) -> Iterator[None]:
        """However this context is left, nothing runs any more; what ended just before is added to `last`."""
        try:
            yield
        finally:
            try:
                last += self._taken(0.0)
            finally:
                self._engine.close()

    def _submit(self) -> None:
        """Hand over the longest of what there is room for, as long as there is any."""
        most = self._engine.most
        for waiting in self._waiting[:_LOOKED_AT]:
            needs = waiting.work.needs(waiting.n_short_of_memory).within(most)
            if not self._engine.has_room(needs):
                continue
            self._waiting.remove(waiting)
            self._running[waiting.work.name] = waiting
            self._engine.submit(waiting.work.task(needs, waiting.n_failed + 1, waiting.avoid))

    def _taken(self, timeout_s: float) -> list[Ended[W]]:
        return [self._take(outcome) for outcome in self._engine.wait(timeout_s)]

    def _take(self, outcome: Outcome) -> Ended[W]:
        waiting = self._running.pop(outcome.name)
        outcome = waiting.work.checked(outcome)
        if outcome.is_done:
            return Ended(waiting.work, outcome, is_last=True)
        waiting.n_failed += 1
        waiting.n_short_of_memory += outcome.remedy == "memory"
        waiting.avoid = outcome.node_id or waiting.avoid
        is_last = outcome.remedy == "none" or waiting.n_failed >= MAX_ATTEMPTS
        if not is_last:
            insort(self._waiting, waiting, key=_shortness)
        return Ended(waiting.work, outcome, is_last)


def _shortness(waiting: _Waiting[W]) -> float:
    return -waiting.work.seconds
