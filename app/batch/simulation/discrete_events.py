"""Discrete-event simulation of a batch: what measured scenes would take on other machines, and more of them.

One process hands scenes out, the longest first, to workers that map one at a time, as `run_batch` does. Scenes may
take longer than they did (stragglers), and nodes die and come back; what was under way there begins anew, up to the
number of attempts that a batch makes.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import asdict, dataclass
from heapq import heapify, heappop, heappush
from math import inf, isfinite
from typing import Any

import numpy as np

from app.engines.work_queue import MAX_ATTEMPTS
from razer.arrays import Float64Array
from razer.errors import BadInput

_BOUNDS = {
    "workers": (1, inf),
    "dispatch_s": (0, inf),
    "straggler_share": (0, 1),
    "straggler_times": (1, inf),
    "hours_between_failures": (0, inf),
    "restart_s": (0, inf),
}


@dataclass(frozen=True)
class Cluster:
    """Where a batch is simulated.

    Args:
        workers: scenes that are mapped at once.
        dispatch_s: time that handing out one scene takes, one after the other.
        straggler_share: of scenes that take longer.
        straggler_times: how many times as long.
        hours_between_failures: of one worker's node, on average; 0 = never.
        restart_s: until a worker that died is there again.
    """

    workers: int
    dispatch_s: float = 0.0
    straggler_share: float = 0.0
    straggler_times: float = 3.0
    hours_between_failures: float = 0.0
    restart_s: float = 300.0

    def __post_init__(self) -> None:
        """Raise BadInput for numbers that no cluster has."""
        for name, (least, most) in _BOUNDS.items():
            if not (least <= (value := getattr(self, name)) <= most and isfinite(value)):
                bounds = f"from {least} on" if most == inf else f"from {least} to {most}"
                raise BadInput(f"--{name.replace('_', '-')} {value}: give a number {bounds}")


@dataclass(frozen=True)
class Makespan:
    """How long a simulated batch takes. lower_bound_s: what no order of scenes can undercut, the longest scene or all
    of them shared evenly; busy: share of the workers' time that went into results; lost: attempts that a death ended;
    failed: scenes without a result after all attempts."""

    makespan_s: float
    lower_bound_s: float
    busy: float
    lost: int
    failed: int

    @property
    def over_bound(self) -> float:
        """Times the lower bound."""
        return self.makespan_s / self.lower_bound_s

    def as_json(self) -> dict[str, Any]:
        """All of it, rounded."""
        figures = {name: round(value, 3) for name, value in asdict(self).items()}
        return figures | {"over_bound": round(self.over_bound, 4)}


def simulate(seconds: Sequence[float] | Float64Array, cluster: Cluster, seed: int = 0) -> Makespan:
    """The makespan of scenes that take so many seconds each (N,), N > 0."""
    return _Simulation(np.asarray(seconds, np.float64), cluster, np.random.default_rng(seed)).run()


class _Simulation:
    """Events in the order of time: (when, worker, the scene that it held or -1, whether that is done)."""

    def __init__(self, expected: Float64Array, cluster: Cluster, rng: np.random.Generator) -> None:
        self._cluster, self._rng, self._expected = cluster, rng, expected
        is_slow = rng.random(len(expected)) < cluster.straggler_share
        self._actual = np.where(is_slow, expected * cluster.straggler_times, expected)
        self._waiting = [(-float(length), n) for n, length in enumerate(expected)]
        heapify(self._waiting)
        self._idle = list(range(min(cluster.workers, len(expected))))
        self._death_s = [self._next_death_s(0.0) for _ in self._idle]
        self._attempts = np.zeros(len(expected), int)
        self._events: list[tuple[float, int, int, bool]] = []
        self._now_s = self._dispatched_s = self._useful_s = 0.0
        self._n_lost = self._n_failed = 0

    def run(self) -> Makespan:
        """Until nothing is waiting or under way."""
        ended_s = 0.0
        while self._dispatch() or self._events:
            self._now_s, worker, scene, is_done = heappop(self._events)
            if scene >= 0:
                ended_s = self._now_s
            if scene < 0 or is_done:
                self._idle.append(worker)
                self._useful_s += float(self._actual[scene]) if is_done else 0.0
            else:
                self._die(worker, scene)
        workers = self._cluster.workers
        bound_s = max(float(self._expected.max()), float(self._expected.sum()) / workers)
        busy = self._useful_s / (workers * ended_s)
        return Makespan(ended_s, bound_s, busy, self._n_lost, self._n_failed)

    def _dispatch(self) -> bool:
        """Give every idle worker the longest scene there is; whether any got one."""
        n_waiting = len(self._waiting)
        while self._idle and self._waiting:
            worker, (_, scene) = self._idle.pop(), heappop(self._waiting)
            self._dispatched_s = max(self._dispatched_s, self._now_s) + self._cluster.dispatch_s
            if self._death_s[worker] < self._dispatched_s:  # and came back, while it had nothing to do
                self._death_s[worker] = self._next_death_s(self._dispatched_s)
            finish_s = self._dispatched_s + float(self._actual[scene])
            is_done = finish_s <= self._death_s[worker]
            self._attempts[scene] += 1
            heappush(self._events, (min(finish_s, self._death_s[worker]), worker, scene, is_done))
        return len(self._waiting) < n_waiting

    def _die(self, worker: int, scene: int) -> None:
        """A worker is away for a while; its scene begins anew elsewhere, if it may."""
        self._n_lost += 1
        if self._attempts[scene] < MAX_ATTEMPTS:
            heappush(self._waiting, (-float(self._expected[scene]), scene))
        else:
            self._n_failed += 1
        back_s = self._now_s + self._cluster.restart_s
        self._death_s[worker] = self._next_death_s(back_s)
        heappush(self._events, (back_s, worker, -1, False))

    def _next_death_s(self, from_s: float) -> float:
        hours = self._cluster.hours_between_failures
        return from_s + float(self._rng.exponential(3600 * hours)) if hours else float("inf")
