"""Repeated timing of a piece of work, for the benchmarks of single parts."""

from __future__ import annotations

from collections.abc import Callable
from statistics import median
from time import perf_counter

_ROUNDS = 30


def median_ms(work: Callable[[], object]) -> float:
    """Milliseconds of one round, median of 30 after one that warms up."""
    work()
    times_ms = []
    for _ in range(_ROUNDS):
        started_s = perf_counter()
        work()
        times_ms.append(1000 * (perf_counter() - started_s))
    return median(times_ms)
