"""Names of the instances of a map: by votes and embeddings, out of any list, with probabilities."""

from __future__ import annotations

from collections.abc import Sequence
from functools import cached_property

import numpy as np

from razer.arrays import BoolArray, Float64Array, IndexArray
from razer.class_votes import ClassVote
from razer.query.embedding_table import EmbeddingTable
from razer.query.name_probability import NameParts
from razer.query.text_queries import TextQueryEncoder
from razer.query.vote_table import NameList, VoteTable


class InstanceNames:
    """What the M instances of a map may be called."""

    def __init__(
        self, hypotheses: EmbeddingTable, votes: Sequence[Sequence[ClassVote]], queries: TextQueryEncoder
    ) -> None:
        """hypotheses: embeddings of the instances; votes: for each of them, in that order; queries: what knows the
        vectors of names."""
        self._hypotheses, self._votes, self._queries = hypotheses, votes, queries

    @property
    def has_votes(self) -> BoolArray:
        """Whether a segmenter called an instance anything (M,)."""
        return np.array([bool(votes) for votes in self._votes], bool)

    @cached_property
    def table(self) -> VoteTable:
        """The votes, for names that have a vector."""
        said = sorted({vote.name for votes in self._votes for vote in votes})
        known = [name for name in said if self._queries.knows(name)]
        vectors = dict(zip(known, self._queries.vectors(known), strict=True)) if known else {}
        return VoteTable.of(self._votes, vectors)

    def parts(self, names: Sequence[str]) -> NameParts:
        """What the probabilities of some names are made of. Raises BadInput for a name that a table lacks."""
        named = NameList(names, self._queries.vectors(names))
        others = self._queries.negatives.vectors
        return NameParts.of(self._hypotheses, self.table, named, others, self._queries.embeds_names)

    def log_probabilities(self, names: Sequence[str]) -> Float64Array:
        """The logarithm (M, N) of the probability that each instance is called each of N names, which compete. Raises
        BadInput for a name that a table lacks."""
        return self.parts(names).log_probabilities()

    def with_said(self, names: Sequence[str]) -> list[str]:
        """Some names, and those that were said of any instance and mean none of them."""
        meant = self.table.means(NameList(names, self._queries.vectors(names))).any(axis=1)
        return [*names, *(said for said, is_meant in zip(self.table.said.names, meant, strict=True) if not is_meant)]

    def said_among(self, rows: IndexArray, names: NameList) -> IndexArray:
        """Those `rows` (K,) of a list that were said of any instance."""
        return rows[self.table.means(names)[:, rows].any(axis=0)]
