"""Profiling hooks: named stages of the work, measurable from outside. `with stage("lift"):` costs next to nothing until
a program hands in something that measures."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import AbstractContextManager, contextmanager, nullcontext
from contextvars import ContextVar

Measure = Callable[[str], AbstractContextManager[None]]
_measure: ContextVar[Measure] = ContextVar("measure", default=lambda name: nullcontext())


def stage(name: str) -> AbstractContextManager[None]:
    """The context of one named stage of the work."""
    return _measure.get()(name)


@contextmanager
def measured_by(measure: Measure) -> Iterator[None]:
    """Within this context every stage is handed to `measure`."""
    token = _measure.set(measure)
    try:
        yield
    finally:
        _measure.reset(token)
