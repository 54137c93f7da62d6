"""Embedding table: the banks of all instances in one array, for ranking."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from razer.arrays import Float32Array, Float64Array, IndexArray, Int64Array


@dataclass(frozen=True)
class EmbeddingTable:
    """The R hypotheses of M instances, those of one instance in a row, its strongest first: ids (M,), starts (M,) rows
    of the strongest, vectors (R, D) float32 of unit length, relative_shares (R,) in (0, 1] of the strongest's share.
    """

    ids: Int64Array
    starts: IndexArray
    vectors: Float32Array
    relative_shares: Float64Array

    @classmethod
    def of(cls, banks: Mapping[int, tuple[Float32Array, Float64Array]]) -> EmbeddingTable:
        """Those of {id: (embeddings (J, D), weights (J,)), the strongest first}, unless there are none."""
        nonempty = {i: bank for i, bank in banks.items() if len(bank[1])}
        vectors, weights = [v for v, _ in nonempty.values()], [w for _, w in nonempty.values()]
        width = vectors[0].shape[1] if vectors else 0
        return cls(
            ids=np.array(list(nonempty), np.int64),
            starts=np.cumsum([0, *(len(w) for w in weights)], dtype=np.intp)[:-1],
            vectors=np.concatenate([np.zeros((0, width), np.float32), *vectors]),
            relative_shares=np.concatenate([np.zeros(0), *(w / w[0] for w in weights)]),
        )

    def select(self, rows: IndexArray) -> EmbeddingTable:
        """Only some instances, by their rows of M."""
        ends = np.append(self.starts[1:], len(self.vectors))
        counts = ends[rows] - self.starts[rows]
        starts = np.cumsum(counts) - counts
        kept = np.arange(counts.sum()) + np.repeat(self.starts[rows] - starts, counts)
        return EmbeddingTable(self.ids[rows], starts, self.vectors[kept], self.relative_shares[kept])

    def __len__(self) -> int:
        return len(self.ids)

    def best(self, values: Float64Array) -> Float64Array:
        """The largest of the values (R, ...) of each instance, (M, ...)."""
        return np.maximum.reduceat(values, self.starts, axis=0) if len(self) else values
