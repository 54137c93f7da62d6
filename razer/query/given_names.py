"""Names that people gave instances by hand: certain, so that neither votes nor embeddings bear on them."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from razer.arrays import Float64Array
from razer.query.embedding_table import EmbeddingTable
from razer.query.kinds import NameSet, expand
from razer.query.phrases import plain, singulars
from razer.query.ranking import SAME_NAME, SHARPNESS, TextRanking
from razer.query.text_queries import TextQueryEncoder

_NOTHING = NameSet(np.zeros(0, np.intp), ())


@dataclass(frozen=True, slots=True)
class GivenMatch:
    """The probability that a text means an instance by its given name; `through` and `kind` as a hit has them."""

    score: float
    through: str | None = None
    kind: str | None = None


class GivenNames:
    """The instances of a map that people named, by id."""

    def __init__(self, names: Mapping[int, str], queries: TextQueryEncoder | None) -> None:
        """`queries`: what knows the vectors of names, if anything does."""
        self.names, self._queries = names, queries

    def by_words(self, text: str) -> dict[int, GivenMatch]:
        """Those that a text means by its words alone: their name, its plural, or a kind that it belongs to, as a "piano
        bench" does to what a bench does."""
        if not self.names or not text.strip():
            return {}
        found = {i: GivenMatch(1.0) for i, name in self.names.items() if same_words(text, name)}
        heads = {i: _heads(name) for i, name in self.names.items()}
        listed = tuple(dict.fromkeys(head for of_name in heads.values() for head in of_name))
        meant = expand(text, listed) or _NOTHING
        kind_of = {listed[row]: kind for row, kind in zip(meant.rows, meant.kinds, strict=True)}
        matches = {i: next((head for head in of_name if head in kind_of), None) for i, of_name in heads.items()}
        kinds = {i: GivenMatch(1.0, self.names[i], kind_of[head]) for i, head in matches.items() if head}
        return kinds | found

    def asked(self, text: str, *, by_kind: bool) -> dict[int, GivenMatch]:
        """How probably a text means each of them: by its words, `by_kind` as a kind, too; else by what the embedder
        makes of text and name, and not at all where it knows one of them only."""
        found = {i: match for i, match in self.by_words(text).items() if by_kind or match.through is None}
        others = {i: name for i, name in self.names.items() if i not in found}
        return found | {i: GivenMatch(score) for i, score in self._by_vectors(text, others).items()}

    def probabilities(self, names: Sequence[str]) -> dict[int, Float64Array]:
        """The probability (N,) of each of N names for each of them: all for the name that was given, else by how alike
        it is to each; instances whose name means nothing to the embedder are left out."""
        return {i: chances for i, name in self.names.items() if (chances := self._shares(name, names)) is not None}

    def _by_vectors(self, text: str, names: Mapping[int, str]) -> dict[int, float]:
        known = [name for name in dict.fromkeys(names.values()) if self._knows(name)]
        if not known or not self._knows(text):
            return dict.fromkeys(names, 0.0)
        assert self._queries is not None
        vectors, query = self._queries.vectors(known), self._queries.vectors([text])
        if self._queries.is_table:
            scores = (vectors @ query[0] > SAME_NAME).astype(np.float64)
        else:
            table = EmbeddingTable.of({row: (vectors[row : row + 1], np.ones(1)) for row in range(len(known))})
            scores = TextRanking(table, self._queries.negatives).scores(query)[:, 0]
        score_of = dict(zip(known, scores.tolist(), strict=True))
        return {i: score_of.get(name, 0.0) for i, name in names.items()}

    def _shares(self, given: str, names: Sequence[str]) -> Float64Array | None:
        for is_same in (lambda name: plain(name) == plain(given), lambda name: same_words(name, given)):
            rows = [row for row, name in enumerate(names) if is_same(name)]
            if rows:
                return np.eye(len(names))[rows[0]]
        if not names or not self._knows(given):
            return None
        assert self._queries is not None
        logits = SHARPNESS * (self._queries.vectors(names) @ self._queries.vectors([given])[0]).astype(np.float64)
        shares = np.exp(logits - logits.max())
        return np.asarray(shares / shares.sum(), np.float64)

    def _knows(self, name: str) -> bool:
        queries = self._queries
        return queries is not None and queries.knows_words and queries.knows(name)


def _heads(name: str) -> list[str]:
    """A name, and what is left of it without its first words: "red office chair", "office chair", "chair"."""
    words = plain(name).split()
    return [" ".join(words[start:]) for start in range(len(words))]


def same_words(one: str, other: str) -> bool:
    """Whether two names are the same but for articles, case and number."""
    return not set(singulars(plain(one))).isdisjoint(singulars(plain(other)))
