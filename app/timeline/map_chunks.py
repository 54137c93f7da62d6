"""Chunks of 4^3 blocks of the map, each logged again only when it has been observed much more often.

A chunk observed n times is logged about log(n) times, which keeps the timeline small and logging cheap.
"""

from __future__ import annotations

import numpy as np

from razer.arrays import Int32Array
from razer.mesh.mesh_chunks import Chunk

BLOCKS_PER_EDGE = 4


class ChunkSchedule:
    """Counts how often each chunk's blocks were observed, and which chunks are due to be logged."""

    def __init__(self, growth: float) -> None:
        self._growth = growth
        self._observations: dict[Chunk, int] = {}
        self._logged: dict[Chunk, int] = {}

    def observe(self, block_keys: Int32Array) -> None:
        """Take in the keys (M, 3) of the blocks that one frame changed."""
        chunks, counts = np.unique(block_keys // BLOCKS_PER_EDGE, axis=0, return_counts=True)
        for key, count in zip(chunks.tolist(), counts.tolist(), strict=True):
            chunk = Chunk(*key)
            self._observations[chunk] = self._observations.get(chunk, 0) + count

    def take_due(self) -> list[Chunk]:
        """The chunks observed `growth` times as often as when last taken; they count as logged from now on."""
        due = [c for c, n in self._observations.items() if n >= self._growth * self._logged.get(c, 0)]
        self._logged.update((chunk, self._observations[chunk]) for chunk in due)
        return due

    def invalidate(self) -> None:
        """All chunks are due again, since the whole map moved."""
        self._logged = dict.fromkeys(self._logged, 0)
