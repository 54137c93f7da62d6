"""Predicted masks on the truth's vertices, which may overlap, each looked up when it is needed."""

from __future__ import annotations

from collections.abc import Iterator, Mapping

import numpy as np

from razer.arrays import BoolArray, Int64Array, IntArray


class VertexMasks(Mapping[int, Int64Array]):
    """The vertex numbers (M,) of each mask, increasing, by id in increasing order. They are made anew each time: many
    masks of millions of vertices are only held as the prediction has them."""

    def __init__(self, masks: Mapping[int, IntArray | BoolArray], n_vertices: int) -> None:
        """The masks on V vertices, given as vertex numbers or as one truth value each; raises ValueError for those that
        do not fit."""
        for number, mask in masks.items():
            _check(mask, n_vertices, number)
        self._masks, self._n_vertices = masks, n_vertices
        self._counts: BoolArray | None = None

    def among(self, counts: BoolArray) -> VertexMasks:
        """The masks on the vertices that count (V,) alone, numbered among these."""
        chosen = VertexMasks({}, self._n_vertices)
        chosen._masks, chosen._counts = self._masks, counts
        return chosen

    def __getitem__(self, number: int) -> Int64Array:
        mask = self._masks[number]
        if mask.dtype != np.bool_:
            inside = np.zeros(self._n_vertices, np.bool_)
            inside[mask] = True
            mask = inside
        return np.flatnonzero(mask if self._counts is None else mask[self._counts])

    def __iter__(self) -> Iterator[int]:
        return iter(sorted(self._masks))

    def __len__(self) -> int:
        return len(self._masks)


def _check(mask: IntArray | BoolArray, n_vertices: int, number: int) -> None:
    if mask.dtype == np.bool_ and len(mask) != n_vertices:
        raise ValueError(f"{len(mask)} predicted labels for {n_vertices} true vertices: one of each is needed")
    if mask.dtype != np.bool_ and len(mask) and not 0 <= mask.min() <= mask.max() < n_vertices:
        raise ValueError(f"mask {number} names vertices that the truth's {n_vertices} do not have")
