"""Names of the instances of a map: by votes and embeddings, out of any list, with probabilities."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from razer.arrays import BoolArray, Float64Array
from razer.class_votes import ClassVote
from razer.query.embedding_table import EmbeddingTable
from razer.query.name_probability import WITHIN_REACH, NameParts, fit_spread
from razer.query.naming import name_log_shares
from razer.query.text_queries import TextQueryEncoder
from razer.query.vote_table import NameList, VoteTable


@dataclass(frozen=True)
class NameChances:
    """Probabilities (M, N) of N names for the M instances of a map, of which those hold that have votes (M,)."""

    names: Sequence[str]
    probabilities: Float64Array
    has_votes: BoolArray

    def runner_up(self, row: int) -> tuple[str, float] | None:
        """The most probable name but the first, if it is within reach of it."""
        chances = self.probabilities[row]
        if not self.has_votes[row] or len(chances) < 2:
            return None
        best = 1 + int(chances[1:].argmax())
        return (self.names[best], float(chances[best])) if chances[best] >= WITHIN_REACH * chances[0] else None


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
        """Whether a segmenter called an instance anything (M,) whose vector is known."""
        return self.table.has_votes

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
        fit = name_log_shares(self._hypotheses, named.vectors) / self._spread
        if self._queries.embeds_names:
            fit[self.has_votes] = 0.0
        return NameParts.of(self.table, fit, named, self._queries.negatives.vectors)

    @cached_property
    def _spread(self) -> float:
        return fit_spread(self._hypotheses, self._queries.negatives.vectors)

    def log_probabilities(self, names: Sequence[str]) -> Float64Array:
        """The logarithm (M, N) of the probability that each instance is called each of N names, which compete. Raises
        BadInput for a name that a table lacks."""
        return self.parts(names).log_probabilities()

    def asked(self, text: str) -> NameChances | None:
        """How probable a text is as a name, in competition with all that was said in the map. None where votes do not
        bear upon it: there are none, or it is no name that they could have been for, but an encoder's free text. Raises
        BadInput for a name that a table lacks."""
        if not self.has_votes.any():
            return None
        is_said = self.table.means(NameList([text], self._queries.vectors([text])))[:, 0]
        if not (is_said.any() or self._queries.is_table):
            return None
        names = [text, *(said for said, same in zip(self.table.said.names, is_said, strict=True) if not same)]
        return NameChances(names, np.exp(self.log_probabilities(names)), self.has_votes)

    def asked_any(self, names: NameList) -> NameChances | None:
        """How probable each of N names is that was said in the map, in competition with all that was; others are not
        probable at all. None without votes."""
        if not self.has_votes.any():
            return None
        chances = np.exp(self.log_probabilities(self.table.said.names))
        return NameChances(names.names, chances @ self.table.means(names), self.has_votes)
