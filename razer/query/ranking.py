"""Which instances a query means, and whether any of them is meant at all (RAZER section IV-I).

The cosine of a text to an image says little by itself: some words are near everything, some things near every word.
What a query says of an instance is therefore set against what other names say of it: the contrast. All figures below
were found with CLIP ViT-B/32 vectors of LVIS by `razer ablate --queries`, which prints precision over recall.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.special import expit

from razer.arrays import Float32Array, Float64Array, IndexArray
from razer.query.embedding_table import EmbeddingTable

# CLIP is trained with products of 100; names are told apart best a little above.
SHARPNESS = 150.0
# What the instances of a map have in common says little about one of them, and in part is taken out of each.
COMMON_SHARE = 0.4
# Where there are fewer instances than this, what they have in common is rather what they are.
FEW_INSTANCES = 10
# Weaker hypotheses are often a neighbour's: one of half the strongest's share is e^-5.5 as good.
SHARE_POWER = 8.0
# From evidence to the probability that a query is present, where every other one is: a logistic fit.
SLOPE, EVEN_EVIDENCE = 0.86, 3.66
# Above it a query counts as present: 91 % of these are right, and 82 % of those present are found.
PRESENT = 0.6
# Names this near to the query are the query.
SAME_NAME = 0.99
_ROWS_AT_ONCE = 4096


@dataclass(frozen=True)
class NegativePrompts:
    """Names that a query competes with: names (N,), vectors (N, D) of unit length."""

    names: Sequence[str]
    vectors: Float32Array


class TextRanking:
    """The instances of a map, ready for queries by text."""

    def __init__(self, hypotheses: EmbeddingTable, contrast: NegativePrompts) -> None:
        self._hypotheses, self._contrast = hypotheses, contrast
        self._common = COMMON_SHARE * common_part(hypotheses)
        self._prior = SHARE_POWER * np.log(hypotheses.relative_shares)
        self._any_name = self._likeness_of_any_name()

    def scores(self, queries: Float32Array) -> Float64Array:
        """The probability (M, N) that each instance is what a query (N, D) means, `PRESENT` or more for present."""
        probability: Float64Array = expit(SLOPE * (self.evidence(queries) - EVEN_EVIDENCE))
        return probability

    def evidence(self, queries: Float32Array) -> Float64Array:
        """By which factor (M, N), as a logarithm, each query names an instance better than names of the contrast do
        on average; of an instance's hypotheses the best counts."""
        same = self._contrast.vectors @ queries.T > SAME_NAME
        n_others = np.maximum(len(same) - same.sum(axis=0), 1)
        repeated = np.flatnonzero(same.any(axis=1))
        share = np.exp(self._likeness(self._contrast.vectors[repeated]) - self._any_name[:, None])
        own_share = np.minimum(share @ same[repeated].astype(np.float64), 1 - 1e-9)
        others = self._any_name[:, None] + np.log1p(-own_share) - np.log(n_others)
        return self._hypotheses.best(self._likeness(queries) - others + self._prior[:, None])

    def likeness(self, texts: Float32Array) -> Float64Array:
        """Which of N texts (N, D) suits an instance best is where a row of (M, N) is largest."""
        relative = self._likeness(texts) - self._any_name[:, None] + self._prior[:, None]
        return self._hypotheses.best(relative)

    def nearest_names(self, rows: IndexArray) -> list[str]:
        """The name of the contrast nearest to the strongest hypothesis of each of some instances (rows of M)."""
        strongest = self._hypotheses.vectors[self._hypotheses.starts[rows]]
        likeness = strongest @ self._contrast.vectors.T - self._contrast.vectors @ self._common
        return [self._contrast.names[i] for i in likeness.argmax(axis=1)]

    def _likeness(self, texts: Float32Array) -> Float64Array:
        """What each of N texts (N, D) has in common with each hypothesis (R, N), as a logarithm."""
        product = self._hypotheses.vectors @ texts.T - texts @ self._common
        return SHARPNESS * product.astype(np.float64)

    def _likeness_of_any_name(self) -> Float64Array:
        """log sum exp of the likeness to all names of the contrast, (R,)."""
        vectors, names = self._hypotheses.vectors, self._contrast.vectors
        result = np.zeros(len(vectors))
        for start in range(0, len(vectors), _ROWS_AT_ONCE):
            part = SHARPNESS * (vectors[start : start + _ROWS_AT_ONCE] @ names.T - names @ self._common)
            top = part.max(axis=1)
            result[start : start + _ROWS_AT_ONCE] = top + np.log(np.exp(part - top[:, None]).sum(axis=1))
        return result


def image_scores(hypotheses: EmbeddingTable, query: Float32Array) -> Float64Array:
    """How alike each instance (M,) is to an image vector (D,), in [0, 1]: the cosine of what sets both apart from
    what all instances have in common. `PRESENT` or more counts as present."""
    common = common_part(hypotheses)
    own, asked = hypotheses.vectors - common, query - common
    lengths = np.linalg.norm(own, axis=1) * np.linalg.norm(asked)
    cosines = (own @ asked) / np.maximum(lengths, 1e-9)
    return np.clip(hypotheses.best(cosines.astype(np.float64)), 0.0, 1.0)


def common_part(hypotheses: EmbeddingTable) -> Float32Array:
    """What instances have in common (D,): the mean of their strongest hypotheses, less of it where they are few."""
    n = len(hypotheses)
    if n == 0:
        return np.zeros(hypotheses.vectors.shape[1], np.float32)
    mean = hypotheses.vectors[hypotheses.starts].mean(axis=0)
    return (n / (n + FEW_INSTANCES) * mean).astype(np.float32)
