"""Ranking of instances for text and image queries, with a calibrated probability of presence (RAZER section IV-I).

The cosine of a text to an image says little by itself: some words are near everything, some things near every word.
Each query therefore competes with other names, the negative prompts, as in a softmax classifier. All figures below
were found with CLIP ViT-B/32 vectors of LVIS by `razer ablate --queries`, which prints precision over recall.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from razer.arrays import BoolArray, Float32Array, Float64Array
from razer.query.embedding_table import EmbeddingTable

# CLIP is trained with products of 100; names are told apart best a little above.
SHARPNESS = 150.0
# What the instances of a map have in common says little about one of them, and in part is taken out of each.
COMMON_SHARE = 0.4
# Where there are fewer instances than this, what they have in common is rather what they are.
FEW_INSTANCES = 10
# Weaker hypotheses are often a neighbour's: one of half the strongest's share is e^-5.5 as good.
SHARE_POWER = 8.0
# From the log ratio to the probability that a query is present, where every other one is: a logistic fit.
SLOPE, EVEN_LOG_RATIO = 0.86, 3.66
# Above it a query counts as present: 91 % of these are right, and 82 % of those present are retrieved.
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

    def __init__(
        self, hypotheses: EmbeddingTable, negatives: NegativePrompts, all_of: EmbeddingTable | None = None
    ) -> None:
        """`all_of`, the instances whose common part is taken out, if other than those that are ranked."""
        self._hypotheses, self._negatives = hypotheses, negatives
        self._common = COMMON_SHARE * common_part(hypotheses if all_of is None else all_of)
        self._prior = SHARE_POWER * np.log(hypotheses.relative_shares)
        self._negative_logits = self._log_sum_exp()

    def scores(self, queries: Float32Array) -> Float64Array:
        """The probability (M, N) that each instance is what a query (N, D) means, `PRESENT` or more for present."""
        probability: Float64Array = _logistic(SLOPE * (self.log_ratios(queries) - EVEN_LOG_RATIO))
        return probability

    def set_scores(self, names: Float32Array) -> Float64Array:
        """The probability (M,) that each instance is what one of some names (K, D) means, which do not compete among
        themselves: between a couch and an armchair it is a seat all the same."""
        same = np.any(self._negatives.vectors @ names.T > SAME_NAME, axis=1)[:, None]
        best = self._logits(names).max(axis=1, keepdims=True)
        ratios = self._hypotheses.best(best - self._others(same) + self._prior[:, None])[:, 0]
        probability: Float64Array = _logistic(SLOPE * (ratios - EVEN_LOG_RATIO))
        return probability

    def log_ratios(self, queries: Float32Array) -> Float64Array:
        """By which factor (M, N), as a logarithm, each query names an instance better than the negative prompts do on
        average; of an instance's hypotheses the best counts."""
        others = self._others(self._negatives.vectors @ queries.T > SAME_NAME)
        return self._hypotheses.best(self._logits(queries) - others + self._prior[:, None])

    def _others(self, same: BoolArray) -> Float64Array:
        """The logarithm of the mean of the exponentials (R, Q) of the negative prompts' logits, but for those that are
        the same (P, Q) as each of Q queries."""
        n_others = np.maximum(len(same) - same.sum(axis=0), 1)
        repeated = np.flatnonzero(same.any(axis=1))
        share = np.exp(self._logits(self._negatives.vectors[repeated]) - self._negative_logits[:, None])
        own_share = np.minimum(share @ same[repeated].astype(np.float64), 1 - 1e-9)
        return self._negative_logits[:, None] + np.log1p(-own_share) - np.log(n_others)

    def _logits(self, texts: Float32Array) -> Float64Array:
        """Logits (R, N) of N texts (N, D) for each hypothesis: scaled cosines without the part common to all."""
        product = self._hypotheses.vectors @ texts.T - texts @ self._common
        return SHARPNESS * product.astype(np.float64)

    def _log_sum_exp(self) -> Float64Array:
        """log sum exp (R,) of the logits of all negative prompts."""
        vectors, names = self._hypotheses.vectors, self._negatives.vectors
        result = np.zeros(len(vectors))
        for start in range(0, len(vectors), _ROWS_AT_ONCE):
            logits = SHARPNESS * (vectors[start : start + _ROWS_AT_ONCE] @ names.T - names @ self._common)
            top = logits.max(axis=1)
            result[start : start + _ROWS_AT_ONCE] = top + np.log(np.exp(logits - top[:, None]).sum(axis=1))
        return result


def _logistic(values: Float64Array) -> Float64Array:
    """1 / (1 + exp(-x)), by hand: scipy's takes a third of a second to import."""
    decay = np.exp(-np.abs(values))
    return np.where(values >= 0, 1.0, decay) / (1 + decay)


def image_scores(hypotheses: EmbeddingTable, query: Float32Array, all_of: EmbeddingTable | None = None) -> Float64Array:
    """How alike each instance (M,) is to an image vector (D,), in [0, 1]: the cosine of what sets both apart from
    what all instances have in common. `PRESENT` or more counts as present; `all_of` as above."""
    common = common_part(hypotheses if all_of is None else all_of)
    own, queried = hypotheses.vectors - common, query - common
    lengths = np.linalg.norm(own, axis=1) * np.linalg.norm(queried)
    cosines = (own @ queried) / np.maximum(lengths, 1e-9)
    return np.clip(hypotheses.best(cosines.astype(np.float64)), 0.0, 1.0)


def common_part(hypotheses: EmbeddingTable) -> Float32Array:
    """What instances have in common (D,): the mean of their strongest hypotheses, less of it where they are few."""
    n = len(hypotheses)
    if n == 0:
        return np.zeros(hypotheses.vectors.shape[1], np.float32)
    mean = hypotheses.vectors[hypotheses.starts].mean(axis=0)
    return (n / (n + FEW_INSTANCES) * mean).astype(np.float32)
