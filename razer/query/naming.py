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


def set_shares(hypotheses: EmbeddingTable, names: Float32Array, members: IndexArray) -> Float64Array:
    """The probability (M,) that an instance's name is one of some `members` (K,) of the names (N, D): their share in
    the softmax over all names; of an instance's hypotheses the best counts, and weaker ones less."""
    chosen = [np.exp(shares[:, members]).sum(axis=1) for shares in _log_shares(hypotheses, hypotheses, names)]
    share: Float64Array = hypotheses.best(np.concatenate(chosen) * hypotheses.relative_shares**SHARE_POWER)
    return np.minimum(share, 1.0)


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
        yield _log_softmax(SHARPNESS * (vectors @ names.T - offset).astype(np.float64))


def _log_softmax(logits: Float64Array) -> Float64Array:
    above = logits - logits.max(axis=1, keepdims=True)
    return above - np.log(np.exp(above).sum(axis=1, keepdims=True))
