"""Probability of names: what a segmenter said of an instance and what its embeddings are like, in one currency.

The logarithm of the probability of a name is, but for a constant, the sum of three parts: how often it was said, from
how many sides; how alike it is to what was said; and how well the embeddings fit it, in units of how much the fits of
names differ. So no unit of an embedder is left, and three weights are all there is to learn.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from razer.arrays import Float32Array, Float64Array
from razer.query.embedding_table import EmbeddingTable
from razer.query.naming import name_log_shares
from razer.query.vote_table import NameList, VoteTable

# What all names of a list together are worth before anything is said, in views: a longer list has no more of it.
NEVER_SAID_VIEWS = 3.0
# From this share of the best name's probability on, the next best is worth telling.
WITHIN_REACH = 0.5


@dataclass(frozen=True)
class NameWeights:
    """Weights of the three parts. Fitted by `razer ablate --naming` to 702 things of apartments 80 to 82 under errors
    `detector`, every 3rd and every 6th of 600 frames; docs/queries.md has the figures on these and on other worlds."""

    said: float = 1.25
    alike: float = 1.69
    vectors: float = 1.56


@dataclass(frozen=True)
class NameParts:
    """For each of M instances and N names: said, the logarithm of how often it was, against never; alike, how much it
    is like what was said; fit, how well the embeddings fit it."""

    said: Float64Array
    alike: Float64Array
    fit: Float64Array

    @classmethod
    def of(cls, votes: VoteTable, fit: Float64Array, names: NameList, others: Float32Array) -> NameParts:
        """The parts for the names of a list: fit (M, N), as above; others (P, D), unit vectors of names of all kinds,
        which the likeness of names is measured by."""
        never_said = NEVER_SAID_VIEWS / max(len(names.names), 1)
        return cls(np.log1p(votes.evidence_for(names) / never_said), votes.likeness_to(names, others), fit)

    def log_probabilities(self, weights: NameWeights = NameWeights()) -> Float64Array:
        """The logarithm (M, N) of the probability of each name of the list; those of an instance add up to 1."""
        logits = weights.said * self.said + weights.alike * self.alike + weights.vectors * self.fit
        above = logits - logits.max(axis=1, keepdims=True, initial=-np.inf)
        log_probability: Float64Array = above - np.log(np.exp(above).sum(axis=1, keepdims=True))
        return log_probability


def fit_spread(hypotheses: EmbeddingTable, others: Float32Array) -> float:
    """The unit of fits: how much the logarithms of the shares of names of all kinds (P, D) differ for one instance, as
    their standard deviation, the median over the instances."""
    return max(float(np.median(name_log_shares(hypotheses, others).std(axis=1))), 1e-6) if len(hypotheses) else 1.0
