"""Touching image regions, and the merging of those that belong together, cheapest first."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from razer.arrays import Float32Array, Float64Array, Int32Array, Int64Array


@dataclass(frozen=True, slots=True)
class RegionGraph:
    """Regions 0 .. N-1 and the pairs of them that touch.

    sums (N, A): what adds up over a region's pixels, column 0 being their number. pairs (E, 2): smaller index
    first. boundary (E, B): what adds up along the pair's common border, column 0 being its length. region
    (N,): where each region went; one that went elsewhere has sums of 0 and is in no pair."""

    sums: Float64Array
    pairs: Int64Array
    boundary: Float64Array
    region: Int64Array

    @classmethod
    def of(
        cls, labels: Int32Array, n: int, pixels: Float32Array, borders: tuple[Float32Array, Float32Array], every: int
    ) -> RegionGraph:
        """The graph of n regions in an (h, w) label image, -1 = nobody. What adds up is given by pixels
        (A, h', w') at every so many pixels and, towards the right and the lower neighbour, by borders
        (B, h, w)."""
        place = labels[::every, ::every].ravel() + 1
        sums = np.zeros((n, len(pixels)))
        for column, image in enumerate(pixels):
            sums[:, column] = np.bincount(place, image.ravel(), n + 1)[1:]
        flat, pairs, values = labels.ravel(), [], []
        for border, (down, right) in zip(borders, ((0, 1), (1, 0)), strict=True):
            here, there = labels[: len(labels) - down, : labels.shape[1] - right], labels[down:, right:]
            parted = np.zeros(labels.shape, bool)
            parted[: here.shape[0], : here.shape[1]] = (here != there) & (np.minimum(here, there) >= 0)
            touching = np.flatnonzero(parted)
            other = touching + (down * labels.shape[1] + right)
            pairs.append(np.stack([flat[touching], flat[other]], axis=1).astype(np.int64))
            values.append(border.reshape(len(border), -1)[:, touching].T.astype(np.float64))
        return cls(sums, *_added_up(np.concatenate(pairs), np.concatenate(values), n), np.arange(n))

    def merged(self, cost: Callable[[RegionGraph], Float64Array]) -> RegionGraph:
        """The graph after merging regions into larger neighbours, each into its cheapest, until no pair's
        cost (E,) is below 1. Costs are asked afresh after each round; equal ones go by region number."""
        graph = self
        while True:
            target = _targets(graph, cost(graph))
            moved = np.flatnonzero(target != np.arange(len(target)))
            if len(moved) == 0:
                return graph
            graph = graph._contracted(target, moved)

    def _contracted(self, target: Int64Array, moved: Int64Array) -> RegionGraph:
        sums = self.sums.copy()
        np.add.at(sums, target[moved], sums[moved])
        sums[moved] = 0
        pairs = target[self.pairs]
        apart = pairs[:, 0] != pairs[:, 1]
        summed = _added_up(pairs[apart], self.boundary[apart], len(target))
        return RegionGraph(sums, *summed, target[self.region])


def _added_up(pairs: Int64Array, values: Float64Array, n: int) -> tuple[Int64Array, Float64Array]:
    """Equal pairs, whichever way round, made one, and their values (E, B) summed."""
    keys, place = np.unique(pairs.min(axis=1) * n + pairs.max(axis=1), return_inverse=True)
    sums = np.zeros((len(keys), values.shape[1]))
    for column in range(values.shape[1]):
        sums[:, column] = np.bincount(place, values[:, column], len(keys))
    return np.stack(np.divmod(keys, n), axis=1), sums


def _targets(graph: RegionGraph, cost: Float64Array) -> Int64Array:
    """Where each region goes in this round: a star of smaller ones into each larger one."""
    size = graph.sums[:, 0]
    target = np.arange(len(size))
    wanted = np.flatnonzero(cost < 1)
    order = wanted[np.argsort(-cost[wanted], kind="stable")]
    best = np.full(len(size), -1)
    best[graph.pairs[order].ravel()] = np.repeat(order, 2)  # the last to write, the cheapest, stays
    movers = np.flatnonzero(best >= 0)
    other = graph.pairs[best[movers]].sum(axis=1) - movers
    smaller = (size[movers] < size[other]) | ((size[movers] == size[other]) & (movers > other))
    movers, other = movers[smaller], other[smaller]
    settled = ~np.isin(other, movers)  # whose target moves itself, waits a round
    target[movers[settled]] = other[settled]
    return target
