"""Region adjacency graph, and greedy region merging by lowest cost."""

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
    (N,): the region that each was merged into; a merged one has sums of 0 and is in no pair."""

    sums: Float64Array
    pairs: Int64Array
    boundary: Float64Array
    region: Int64Array

    @classmethod
    def of(
        cls, labels: Int32Array, n: int, pixels: Float32Array, borders: tuple[Float32Array, Float32Array], stride: int
    ) -> RegionGraph:
        """The graph of the regions in a label image.

        Args:
            labels: (h, w), region numbers, -1 = unlabelled.
            n: number of regions.
            pixels: (A, h', w'), what adds up over a region, at every `stride`-th pixel.
            borders: towards the right and the lower neighbour, (B, h, w) each, what adds up along a border.
            stride: pixels.
        """
        owner = labels[::stride, ::stride].ravel() + 1
        sums = np.zeros((n, len(pixels)))
        for column, image in enumerate(pixels):
            sums[:, column] = np.bincount(owner, image.ravel(), n + 1)[1:]
        flat, pairs, values = labels.ravel(), [], []
        for border, (down, right) in zip(borders, ((0, 1), (1, 0)), strict=True):
            label, neighbour = labels[: len(labels) - down, : labels.shape[1] - right], labels[down:, right:]
            is_border = np.zeros(labels.shape, bool)
            is_border[: label.shape[0], : label.shape[1]] = (label != neighbour) & (np.minimum(label, neighbour) >= 0)
            pixel = np.flatnonzero(is_border)
            next_pixel = pixel + (down * labels.shape[1] + right)
            pairs.append(np.stack([flat[pixel], flat[next_pixel]], axis=1).astype(np.int64))
            values.append(border.reshape(len(border), -1)[:, pixel].T.astype(np.float64))
        return cls(sums, *summed_pairs(np.concatenate(pairs), np.concatenate(values), n), np.arange(n))

    def merged(self, cost: Callable[[RegionGraph], Float64Array]) -> RegionGraph:
        """The graph after merging regions into larger neighbours, each into its cheapest, until no pair's
        cost (E,) is below 1. Costs are computed afresh after each round; equal ones go by region number."""
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
        is_distinct = pairs[:, 0] != pairs[:, 1]
        summed = summed_pairs(pairs[is_distinct], self.boundary[is_distinct], len(target))
        return RegionGraph(sums, *summed, target[self.region])


def summed_pairs(pairs: Int64Array, values: Float64Array, n: int) -> tuple[Int64Array, Float64Array]:
    """The distinct unordered pairs, and their values (E, B) summed."""
    keys, index = np.unique(pairs.min(axis=1) * n + pairs.max(axis=1), return_inverse=True)
    sums = np.zeros((len(keys), values.shape[1]))
    for column in range(values.shape[1]):
        sums[:, column] = np.bincount(index, values[:, column], len(keys))
    return np.stack(np.divmod(keys, n), axis=1), sums


def _targets(graph: RegionGraph, cost: Float64Array) -> Int64Array:
    """The region that each is merged into in this round: smaller ones into each larger one."""
    size = graph.sums[:, 0]
    target = np.arange(len(size))
    cheap = np.flatnonzero(cost < 1)
    order = cheap[np.argsort(-cost[cheap], kind="stable")]
    best = np.full(len(size), -1)
    best[graph.pairs[order].ravel()] = np.repeat(order, 2)  # the last to write, the cheapest, stays
    movers = np.flatnonzero(best >= 0)
    partner = graph.pairs[best[movers]].sum(axis=1) - movers
    is_smaller = (size[movers] < size[partner]) | ((size[movers] == size[partner]) & (movers > partner))
    movers, partner = movers[is_smaller], partner[is_smaller]
    is_settled = ~np.isin(partner, movers)  # a region whose partner is merged itself waits a round
    target[movers[is_settled]] = partner[is_settled]
    return target
