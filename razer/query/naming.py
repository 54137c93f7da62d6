"""Naming of instances out of a list of names: a softmax over the list, of what sets an instance apart from the others.

All verbs that name instances do it by this one function. Which one it is was found with CLIP ViT-B/32 vectors of LVIS
by `razer ablate --queries`; the figures are in docs/queries.md.
"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from razer.arrays import Float32Array, Float64Array, IndexArray
from razer.query.embedding_table import EmbeddingTable
from razer.query.ranking import COMMON_SHARE, SHARE_POWER, SHARPNESS, common_part

_ROWS_AT_ONCE = 4096


def name_log_shares(hypotheses: EmbeddingTable, names: Float32Array, rows: IndexArray | None = None) -> Float64Array:
    """The logarithm of each name's share in a softmax over all names (M, N); of an instance's hypotheses the best
    counts, and weaker ones less.

    Args:
        hypotheses: embeddings of the instances of a map.
        names: (N, D) unit vectors of the texts.
        rows: which instances (M of them); None: all.
    """
    chosen = hypotheses if rows is None else hypotheses.select(rows)
    prior = SHARE_POWER * np.log(chosen.relative_shares)
    return chosen.best(np.concatenate(list(_log_shares(hypotheses, chosen, names))) + prior[:, None])


class NameShares:
    """The shares of some of many names (N, D) in a softmax over all of them, for the instances of a map: what all
    names add up to is worked out once, for whatever sets of them are asked for."""

    def __init__(self, hypotheses: EmbeddingTable, names: Float32Array) -> None:
        # In doubles, so that the shares of all names add up to 1 whichever of them are asked for together.
        self._hypotheses, self._names = hypotheses, names.astype(np.float64)
        common = common_part(hypotheses) if len(hypotheses) else np.zeros(names.shape[1])
        self._offsets = self._names @ (COMMON_SHARE * common)
        every = np.arange(len(names))
        rows = np.array_split(hypotheses.vectors, len(hypotheses.vectors) // _ROWS_AT_ONCE + 1)
        self._totals = np.concatenate([_log_sum_exp(self._logits(part, every)) for part in rows])

    def log_shares(self, members: IndexArray) -> Float64Array:
        """The logarithm (M, K) of the share of each of some names (K,), as `name_log_shares`."""
        prior = SHARE_POWER * np.log(self._hypotheses.relative_shares)
        return self._hypotheses.best(self._of_rows(members) + prior[:, None])

    def set_shares(self, members: IndexArray) -> Float64Array:
        """The probability (M,) that an instance's name is one of some (K,): their share together; of an instance's
        hypotheses the best counts, and weaker ones less."""
        chosen = np.exp(self._of_rows(members)).sum(axis=1)
        share: Float64Array = self._hypotheses.best(chosen * self._hypotheses.relative_shares**SHARE_POWER)
        return np.minimum(share, 1.0)

    def _of_rows(self, members: IndexArray) -> Float64Array:
        return self._logits(self._hypotheses.vectors, members) - self._totals[:, None]

    def _logits(self, vectors: Float32Array, members: IndexArray) -> Float64Array:
        logits: Float64Array = SHARPNESS * (vectors @ self._names[members].T - self._offsets[members])
        return logits


def ranked_names(hypotheses: EmbeddingTable, names: Float32Array, rows: IndexArray | None = None) -> IndexArray:
    """The names (N, D) that suit each instance, the best first: their numbers (M, N); arguments as above."""
    if not len(hypotheses):  # which has no width either
        return np.zeros((0, len(names)), np.intp)
    return np.argsort(-name_log_shares(hypotheses, names, rows), axis=1, kind="stable")


def _log_shares(all_of: EmbeddingTable, chosen: EmbeddingTable, names: Float32Array) -> Iterator[Float64Array]:
    """The logarithm of each name's share, for some rows of the chosen hypotheses after the other (R, N)."""
    # Of all instances of the map, whichever of them are named.
    offset = names @ (COMMON_SHARE * common_part(all_of)) if len(all_of) else np.zeros(len(names))
    for vectors in np.array_split(chosen.vectors, len(chosen.vectors) // _ROWS_AT_ONCE + 1):
        logits = SHARPNESS * (vectors @ names.T - offset).astype(np.float64)
        yield logits - _log_sum_exp(logits)[:, None]


def _log_sum_exp(logits: Float64Array) -> Float64Array:
    top = logits.max(axis=1)
    return np.asarray(top + np.log(np.exp(logits - top[:, None]).sum(axis=1)), np.float64)
