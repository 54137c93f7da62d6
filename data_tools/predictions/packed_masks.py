"""Masks over the vertices of one mesh, one bit for each: many large ones in little memory."""

from __future__ import annotations

from collections.abc import Iterator, Mapping

import numpy as np

from razer.arrays import BoolArray, Uint8Array


class PackedMasks(Mapping[int, BoolArray]):
    """Masks (V,) by number, in the order in which they were added; each is unpacked when it is asked for."""

    def __init__(self) -> None:
        self.n_vertices = 0
        self._bits: dict[int, Uint8Array] = {}

    def add(self, mask: BoolArray) -> int:
        """Keep a mask (V,), all of one length, and return its number, the first being 1; raises ValueError."""
        if self._bits and len(mask) != self.n_vertices:
            raise ValueError(f"a mask of {len(mask)} vertices among those of {self.n_vertices}")
        self.n_vertices = len(mask)
        number = len(self._bits) + 1
        self._bits[number] = np.packbits(mask)
        return number

    def __getitem__(self, number: int) -> BoolArray:
        return np.unpackbits(self._bits[number], count=self.n_vertices).view(np.bool_)

    def __iter__(self) -> Iterator[int]:
        return iter(self._bits)

    def __len__(self) -> int:
        return len(self._bits)
