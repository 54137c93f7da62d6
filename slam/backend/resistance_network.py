"""Uncertainty between keyframes as effective resistance of a network, whose resistors are edges with their variances.

Variances add up along a way, and ways side by side share the error as resistors share a current: the variance between
two keyframes, all ways taken together, is the effective resistance between them (Barooah and Hespanha, IEEE Control
Systems 2007).
"""

from __future__ import annotations

from bisect import insort
from collections.abc import Sequence
from heapq import heappop, heappush

import numpy as np

from razer.arrays import Float64Array

NEAREST = 64  # keyframes of the network that are looked at together: ways that lead farther about share little


class ResistanceNetwork:
    """Keyframes, by number, and the edges between them."""

    def __init__(self) -> None:
        self._conductances: dict[int, dict[int, float]] = {}  # from, to
        self._variances: list[float] = []  # of all edges, sorted

    def add(self, a: int, b: int, variance: float) -> None:
        """A further edge between two keyframes."""
        insort(self._variances, variance)
        for one, other in ((a, b), (b, a)):
            from_one = self._conductances.setdefault(one, {})
            from_one[other] = from_one.get(other, 0.0) + 1 / variance

    @property
    def usual_variance(self) -> float:
        """The median variance of an edge; 1 where there are none."""
        return self._variances[len(self._variances) // 2] if self._variances else 1.0

    def joined(self, a: int, b: int) -> bool:
        """Whether there is an edge between two keyframes."""
        return b in self._conductances.get(a, ())

    def variances_from(self, start: int) -> dict[int, float]:
        """The variance between a keyframe and each of the NEAREST ones, itself included; it is somewhat greater than
        that of the whole network, since ways that lead about others are left out."""
        numbers = self._nearest(start)
        if len(numbers) == 1:
            return {start: 0.0}
        # The resistance to each is what one unit of current raises its potential by, where the start is earthed.
        raised = np.linalg.inv(self._laplacian(numbers)[1:, 1:]).diagonal()
        return {start: 0.0, **dict(zip(numbers[1:], raised.tolist(), strict=True))}

    def _nearest(self, start: int) -> list[int]:
        """The NEAREST keyframes along shortest ways, the start first (Dijkstra, 1959)."""
        reached: dict[int, None] = {}
        open_ends = [(0.0, start)]
        while open_ends and len(reached) < NEAREST:
            length, at = heappop(open_ends)
            if at in reached:
                continue
            reached[at] = None
            for other, conductance in self._conductances.get(at, {}).items():
                if other not in reached:
                    heappush(open_ends, (length + 1 / conductance, other))
        return list(reached)

    def _laplacian(self, numbers: Sequence[int]) -> Float64Array:
        """The Laplacian (N, N) of the edges among some keyframes."""
        row = {number: n for n, number in enumerate(numbers)}
        result = np.zeros((len(numbers), len(numbers)))
        for number, n in row.items():
            for other, conductance in self._conductances[number].items():
                if other in row:
                    result[n, row[other]] = -conductance
        np.fill_diagonal(result, -result.sum(axis=1))
        return result
