"""Touching image regions, and merging of the pairs that belong together, cheapest first."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Sums = NDArray[np.floating]


@dataclass(frozen=True, slots=True)
class RegionGraph:
    """Regions 0..N-1 with `sums` (N, A) of what adds up over their pixels, column 0 the pixel count; pairs that
    touch, (E, 2) with the smaller index first, with `boundary` (E, B) of what adds up along their common
    border, column 0 its length; and `region` (R,), where each of the R first regions went."""

    sums: Sums
    pairs: NDArray[np.int64]
    boundary: Sums
    region: NDArray[np.int64]

    @classmethod
    def of(
        cls, labels: NDArray[np.int32], n: int, pixels: Sums, borders: list[Sums], every: int
    ) -> RegionGraph:
        """The graph of an (h, w) label image, -1 = nobody. What to sum up is given by pixels (A, h', w') at
        every so many pixels, and, for the steps to the right and down, by borders (B, h, w)."""
        place = labels[::every, ::every].ravel() + 1
        sums = np.stack([np.bincount(place, image.ravel(), n + 1)[1:] for image in pixels], axis=1)
        first, second, values = [], [], []
        for border, (down, right) in zip(borders, ((0, 1), (1, 0)), strict=True):
            here = labels[: labels.shape[0] - down, : labels.shape[1] - right]
            there = labels[down:, right:]
            touching = np.flatnonzero((here != there) & (here >= 0) & (there >= 0))
            first.append(here.ravel()[touching])
            second.append(there.ravel()[touching])
            values.append(border[:, : here.shape[0], : here.shape[1]].reshape(len(border), -1)[:, touching])
        pairs = np.sort(np.stack([np.concatenate(first), np.concatenate(second)], axis=1), axis=1)
        return cls(sums, *_added_up(pairs, np.concatenate(values, axis=1).T, n), np.arange(n))

    def merged(self, cost: Callable[[RegionGraph], NDArray[np.float64]]) -> RegionGraph:
        """The graph after merging, as long as any pair's cost (E,) is below 1, each region into its cheapest
        larger neighbour. Costs are asked afresh after each round; equal costs go by region number."""
        graph = self
        while True:
            target = _targets(graph, cost(graph))
            if (target == np.arange(len(target))).all():
                return graph
            graph = graph._contracted(target)

    def _contracted(self, target: NDArray[np.int64]) -> RegionGraph:
        moved = np.flatnonzero(target != np.arange(len(target)))
        sums = self.sums.copy()
        np.add.at(sums, target[moved], sums[moved])
        sums[moved] = 0
        pairs = np.sort(target[self.pairs], axis=1)
        apart = pairs[:, 0] != pairs[:, 1]
        pairs, boundary = _added_up(pairs[apart], self.boundary[apart], len(target))
        return RegionGraph(sums, pairs, boundary, target[self.region])


def _added_up(pairs: NDArray, values: Sums, n: int) -> tuple[NDArray[np.int64], Sums]:
    """Equal pairs made one, their values summed."""
    keys, place = np.unique(pairs[:, 0].astype(np.int64) * n + pairs[:, 1], return_inverse=True)
    sums = np.stack([np.bincount(place, column, len(keys)) for column in values.T], axis=1)
    return np.stack(np.divmod(keys, n), axis=1), sums


def _targets(graph: RegionGraph, cost: NDArray[np.float64]) -> NDArray[np.int64]:
    """Where each region goes in this round: a star of smaller ones into each larger one."""
    n = len(graph.sums)
    target = np.arange(n)
    wanted = np.flatnonzero(cost < 1)
    order = wanted[np.argsort(-cost[wanted], kind="stable")]
    best = np.full(n, -1)
    best[graph.pairs[order].ravel()] = np.repeat(order, 2)  # the last write, the cheapest, stays
    movers = np.flatnonzero(best >= 0)
    other = graph.pairs[best[movers]].sum(axis=1) - movers
    size = graph.sums[:, 0]
    smaller = (size[movers] < size[other]) | ((size[movers] == size[other]) & (movers > other))
    movers, other = movers[smaller], other[smaller]
    settled = ~np.isin(other, movers)  # whoever's target moves itself waits a round
    target[movers[settled]] = other[settled]
    return target
