"""Chunks of 2^3 blocks of a growing map, and which of them are shown most out of date."""

from __future__ import annotations

import numpy as np

from razer.arrays import Int32Array
from razer.mesh.mesh_chunks import Chunk

BLOCKS_PER_EDGE = 2
_LOWER = np.stack(np.meshgrid(*3 * [[0, -1]], indexing="ij"), axis=-1).reshape(-1, 3)


class DueChunks:
    """Counts how often each chunk changed, in all and since it was taken last."""

    def __init__(self) -> None:
        self._changes: dict[Chunk, int] = {}
        self._taken: dict[Chunk, int] = {}

    def __len__(self) -> int:
        """How many have changed since they were taken."""
        return sum(n > self._taken.get(chunk, 0) for chunk, n in self._changes.items())

    def observe(self, block_keys: Int32Array) -> None:
        """Take in the keys (M, 3) of blocks that changed: cubes that reach them from lower blocks change, too."""
        reached = np.unique((block_keys[:, None] + _LOWER).reshape(-1, 3) // BLOCKS_PER_EDGE, axis=0)
        for key in reached.tolist():
            chunk = Chunk(*key)
            self._changes[chunk] = self._changes.get(chunk, 0) + 1

    def all_changed(self) -> None:
        """The whole map was replaced: every chunk counts as never taken."""
        self._taken.clear()

    def take(self, most: int) -> list[Chunk]:
        """Those that changed most, by the share of their changes since they were taken last."""
        share = {c: (n - self._taken.get(c, 0)) / n for c, n in self._changes.items()}
        due = sorted((c for c in share if share[c] > 0), key=lambda c: (-share[c], c))[:most]
        self._taken.update((chunk, self._changes[chunk]) for chunk in due)
        return due
