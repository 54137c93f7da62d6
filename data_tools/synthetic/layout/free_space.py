"""Free-space planning: where a camera can be carried, and shortest routes (Dijkstra) between two places."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.ndimage import gaussian_filter1d, label
from scipy.sparse import coo_matrix
from scipy.sparse.csgraph import dijkstra

from data_tools.synthetic.layout.placement import solid_boxes
from data_tools.synthetic.shapes.thing import Thing
from razer.arrays import BoolArray, Float64Array, Uint8Array

CLEAR_M = 0.36
# What is lower is reached over by the arms that hold the camera.
HEIGHTS_M = (1.05, 1.9)
CELL_M = 0.05
_ROOMY_M = 0.6
_SMOOTH_CELLS = 3.0


@dataclass(frozen=True, slots=True, eq=False)
class EmptyCells:
    """Where nothing stands: origin (2,) metres, and empty (I, J) 1 or 0 for cells of CELL_M along x and y; ground
    (I, J) bool: above which of them a camera may be, None = all."""

    origin: Float64Array
    empty: Uint8Array
    ground: BoolArray | None = None

    @classmethod
    def among(cls, things: Iterable[Thing], heights_m: tuple[float, float] = HEIGHTS_M) -> EmptyCells:
        """The cells without any part of the things between two heights, by default those at which a camera is
        carried."""
        boxes = np.concatenate([solid_boxes(thing) for thing in things])
        low, high = boxes[:, 0], boxes[:, 1]
        origin = low[:, :2].min(axis=0) - 0.5
        shape = np.ceil((high[:, :2].max(axis=0) + 0.5 - origin) / CELL_M).astype(int)
        empty = np.ones(shape, np.uint8)
        hit = (low[:, 2] < heights_m[1]) & (high[:, 2] > heights_m[0])
        first = np.floor((low[hit, :2] - origin) / CELL_M).astype(int)
        last = np.floor((high[hit, :2] - origin) / CELL_M).astype(int)
        for (i0, j0), (i1, j1) in zip(first, last, strict=True):
            empty[i0 : i1 + 1, j0 : j1 + 1] = 0
        return cls(origin, empty)


class FreeSpace:
    """The places that a camera can reach from `home` (x, y), or from the free place that is nearest to it within
    reach_m, while it keeps clear_m away from everything; without a home the largest part of all. Raises ValueError
    where nothing within reach, or nothing at all, is free."""

    def __init__(
        self, cells: EmptyCells, home: Sequence[float] | None = None, clear_m: float = CLEAR_M, *, reach_m: float = 0.0
    ) -> None:
        self._origin, self._clear_m = cells.origin, clear_m
        self._room_m = cv2.distanceTransform(cells.empty, cv2.DIST_L2, cv2.DIST_MASK_PRECISE) * CELL_M
        wide = self._room_m > clear_m
        parts, n_parts = label(wide if cells.ground is None else wide & cells.ground)
        sizes = np.bincount(parts.ravel(), minlength=2)
        home_part = int(sizes[1:].argmax()) + 1 if home is None else self._part_at(parts, home, reach_m)
        if home_part == 0 or n_parts == 0:
            raise ValueError("no camera can be anywhere" if home is None else f"no camera can be at {tuple(home)}")
        self._free = parts == home_part
        self._cells = np.argwhere(self._free)
        self._graph = self._connected()

    def _part_at(self, parts: NDArray, home: Sequence[float], reach_m: float) -> int:
        """The number of the part that home, or else the free cell nearest to it, belongs to; 0 = none within reach."""
        if (part := int(parts[self._cell(home)])) or not parts.any():
            return part
        free = np.argwhere(parts > 0)
        away_m = np.linalg.norm(self._origin + (free + 0.5) * CELL_M - home, axis=1)
        return int(parts[tuple(free[away_m.argmin()])]) if away_m.min() <= reach_m else 0

    @property
    def places(self) -> Float64Array:
        """The middles (P, 2) of all cells that can be reached."""
        return self._origin + (self._cells + 0.5) * CELL_M

    def ways(self, places: Float64Array) -> Float64Array:
        """How far it is between places (N, 2) on the routes between them, (N, N); more than metres along things."""
        numbers = [self._number(place) for place in places]
        between: Float64Array = dijkstra(self._graph, indices=numbers)[:, numbers] * CELL_M / 2
        return between

    def nearest(self, point: ArrayLike) -> Float64Array:
        """The place (2,) nearest to a point that can be reached."""
        place: Float64Array = self.places[np.linalg.norm(self.places - np.asarray(point), axis=1).argmin()]
        return place

    def route(self, start: ArrayLike, end: ArrayLike) -> Float64Array:
        """A way (K, 2) between two places, in steps of about a cell, rather in the open than along things."""
        first, last = self._number(start), self._number(end)
        _, before = dijkstra(self._graph, indices=first, return_predecessors=True)
        numbers = [last]
        while numbers[-1] != first:
            numbers.append(before[numbers[-1]])
        route = self._origin + (self._cells[numbers[::-1]] + 0.5) * CELL_M
        smooth: Float64Array = gaussian_filter1d(route, _SMOOTH_CELLS, axis=0, mode="nearest")
        return np.concatenate([route[:1], smooth, route[-1:]])

    def _cell(self, point: Sequence[float]) -> tuple[int, int]:
        i, j = np.floor((np.asarray(point) - self._origin) / CELL_M).astype(int)
        return int(i), int(j)

    def _number(self, point: ArrayLike) -> int:
        return int(np.linalg.norm(self.places - np.asarray(point), axis=1).argmin())

    def _connected(self) -> coo_matrix:
        """The free cells as a graph whose edges are longer the nearer they are to things."""
        number = np.full(self._free.shape, -1)
        number[self._free] = np.arange(len(self._cells))
        roomy_m = max(_ROOMY_M, self._clear_m + 0.1)
        tight = 1 + 3 * ((roomy_m - self._room_m) / (roomy_m - self._clear_m)).clip(0)
        rows: list[NDArray] = []
        for di, dj in ((0, 1), (1, 0), (1, 1), (1, -1)):
            i, j = self._cells.T
            other = number[i + di, j + dj]
            to = other >= 0
            cost = np.hypot(di, dj) * (tight[i, j][to] + tight[i + di, j + dj][to])
            rows.append(np.stack([np.flatnonzero(to), other[to], cost]))
        one, two, cost = np.concatenate(rows, axis=1)
        size = (len(self._cells), len(self._cells))
        pairs = (np.concatenate([one, two]).astype(int), np.concatenate([two, one]).astype(int))
        return coo_matrix((np.concatenate([cost, cost]), pairs), size).tocsr()
