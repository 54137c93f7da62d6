"""Vote table: what a segmenter called the instances of a map, as evidence for the names of a list."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from razer.arrays import BoolArray, Float32Array, Float64Array
from razer.class_votes import ClassVote, name_evidence, usual_score
from razer.query.ranking import SAME_NAME

# A name is as much like another as it can be from here on, in standard deviations of the cosines of names.
MOST_ALIKE = 3.0


@dataclass(frozen=True)
class NameList:
    """Names (N,) with their unit vectors (N, D)."""

    names: Sequence[str]
    vectors: Float32Array


@dataclass(frozen=True)
class VoteTable:
    """The K names that a segmenter said, with their vectors, and how often it did of each of M instances, in views
    (M, K); a row of zeros where it said nothing."""

    said: NameList
    evidence: Float64Array

    @classmethod
    def of(cls, votes: Sequence[Sequence[ClassVote]], vectors: Mapping[str, Float32Array]) -> VoteTable:
        """Those of M instances; names without a vector (D,) are left out."""
        usual = usual_score(vote for of_instance in votes for vote in of_instance)
        by_name = [name_evidence(of_instance, usual) for of_instance in votes]
        names = sorted({name for of_instance in by_name for name in of_instance} & vectors.keys())
        width = len(next(iter(vectors.values()))) if vectors else 0
        rows = np.array([[of_instance.get(name, 0.0) for name in names] for of_instance in by_name])
        stacked = np.stack([vectors[name] for name in names]) if names else np.zeros((0, width), np.float32)
        return cls(NameList(names, stacked), rows.reshape(len(votes), len(names)))

    @property
    def has_votes(self) -> BoolArray:
        """Whether anything was said of each instance (M,)."""
        has_votes: BoolArray = np.any(self.evidence, axis=1)
        return has_votes

    def evidence_for(self, names: NameList) -> Float64Array:
        """How often each of N names, or a synonym of it, was said of each instance, in views (M, N)."""
        evidence: Float64Array = self.evidence @ self.means(names).astype(np.float64)
        return evidence

    def likeness_to(self, names: NameList, others: Float32Array) -> Float64Array:
        """How alike each of N names is to what was said of each instance (M, N): in standard deviations of the cosines
        that what was said has with `others` (P, D), above their mean and `MOST_ALIKE` at most; 0 where nothing was."""
        if not self.said.names:
            return np.zeros((len(self.evidence), len(names.names)))
        cosines = self.said.vectors @ others.T
        spread = np.maximum(cosines.std(axis=1, keepdims=True), 1e-6)
        alike = (self.said.vectors @ names.vectors.T - cosines.mean(axis=1, keepdims=True)) / spread
        alike = np.where(self.means(names), MOST_ALIKE, np.minimum(alike, MOST_ALIKE)).astype(np.float64)
        total = np.maximum(self.evidence.sum(axis=1, keepdims=True), 1e-12)
        likeness: Float64Array = self.evidence / total @ alike
        return likeness

    def means(self, names: NameList) -> BoolArray:
        """Whether each said name means each of N names (K, N): it is the same word, or, where no name of the list is,
        one of the same vector."""
        if not self.said.names:
            return np.zeros((0, len(names.names)), bool)
        same_word = np.array([[said == name for name in names.names] for said in self.said.names])
        same_vector = self.said.vectors @ names.vectors.T > SAME_NAME
        means: BoolArray = same_word | (same_vector & ~same_word.any(axis=1, keepdims=True))
        return means
