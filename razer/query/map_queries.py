"""Queries of the instances of a map: by text, by image, and by lists of names (RAZER section IV-I)."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from razer.arrays import Float32Array, Float64Array, IndexArray
from razer.errors import BadInput
from razer.map_object import Answer, Hit, MapObject
from razer.query.embedding_table import EmbeddingTable
from razer.query.given_names import GivenMatch, GivenNames
from razer.query.instance_names import InstanceNames, NameChances
from razer.query.kinds import NameSet
from razer.query.naming import NameShares, ranked_names
from razer.query.part_answers import better_parts
from razer.query.ranking import PRESENT, TextRanking, image_scores
from razer.query.text_queries import TextQueryEncoder
from razer.query.vote_table import NameList

TextScores = tuple[Float64Array, NameChances | None]


@dataclass(frozen=True)
class MapQueries:
    """What answers for the instances of a map and their parts; what it derives from them is kept for the next query."""

    objects: tuple[MapObject, ...]
    parts: tuple[MapObject, ...]
    encoder: TextQueryEncoder | None

    def by_text(self, text: str, threshold: float) -> Answer:
        """The instances that a text means, as `PanopticMap.query`; those that people named by their names alone."""
        given = self.given_names
        if not given.names:
            return self._by_machine(text, threshold)
        try:
            answer = self._by_machine(text, threshold)
        except BadInput:
            if not (found := given.by_words(text)):
                raise
            return self._with_given(Answer((), threshold), found)
        return self._with_given(answer, given.asked(text, by_kind=self._meaning(text) is not None))

    def by_image(self, vector: Float32Array, threshold: float) -> Answer:
        """The instances that look like a vector (D,), as `PanopticMap.query_image`."""
        self._check(len(vector))
        if not len(self.embedding_table):
            return Answer((), threshold)
        scores = image_scores(self.embedding_table, vector)
        rows = _above(scores, threshold)
        answer = self._answer(scores, rows, threshold, [None] * len(rows))
        if not self.parts:
            return answer
        return self._with_parts(answer, image_scores(self.part_table, vector, self.embedding_table), scores)

    def name_probabilities(self, names: Sequence[str]) -> Float64Array:
        """The probability (M, N) that each instance of `embedding_table` is called each of N names, as
        `PanopticMap.name_probabilities`."""
        self._check(self.known_encoder.vectors(names[:1]).shape[1])
        chances = np.minimum(np.exp(self.instance_names.log_probabilities(names)), 1.0)
        given = self.given_names.probabilities(names) if self.given_names.names else {}
        for row, i in enumerate(self.embedding_table.ids.tolist()):
            chances[row] = given.get(i, chances[row])
        return chances

    @cached_property
    def embedding_table(self) -> EmbeddingTable:
        """The embeddings of all objects."""
        return EmbeddingTable.of({o.id: (o.embeddings, o.weights) for o in self.objects})

    @cached_property
    def part_table(self) -> EmbeddingTable:
        """The embeddings of all parts."""
        return EmbeddingTable.of({part.id: (part.embeddings, part.weights) for part in self.parts})

    @cached_property
    def text_ranking(self) -> TextRanking:
        """The objects, ready for texts; raises BadInput where the embedder cannot tell."""
        negatives = self.known_encoder.negatives
        self._check(negatives.vectors.shape[1])
        return TextRanking(self.embedding_table, negatives)

    @cached_property
    def instance_names(self) -> InstanceNames:
        """What the instances of `embedding_table` may be called; raises BadInput where no embedder is known."""
        votes = {o.id: o.class_votes for o in self.objects}
        of_rows = [votes[i] for i in self.embedding_table.ids.tolist()]
        return InstanceNames(self.embedding_table, of_rows, self.known_encoder)

    @cached_property
    def given_names(self) -> GivenNames:
        """The instances that people named."""
        given = {o.id: o.class_name for o in self.objects if o.is_named_by_hand and o.class_name}
        return GivenNames(given, self.encoder)

    @property
    def known_encoder(self) -> TextQueryEncoder:
        """What encodes texts; raises BadInput where no embedder is known."""
        if self.encoder is None:
            raise BadInput("no embedder is known for this map, so that it cannot be queried by text")
        return self.encoder

    def _by_machine(self, text: str, threshold: float) -> Answer:
        """The instances that a text means, by votes and embeddings. Where only names are known, kinds stand for their
        names, unless something is there of exactly that name."""
        meaning = self._meaning(text)
        if meaning is not None:
            return self._by_kind(meaning, threshold)
        self.known_encoder.query_vector(text)  # tells of kinds, where the text means nothing
        return self._by_name(text, threshold)

    def _meaning(self, text: str) -> NameSet | None:
        """The names that a kind stands for; None for any other text, and where something is there of exactly that
        name, found by votes and embeddings or because somebody called it so."""
        meaning = self.known_encoder.meaning(text)
        if meaning is None or not self.known_encoder.knows(text):
            return meaning
        given, scores = self.given_names, self._text_scores(text)[0]
        machine = [score for i, score in zip(self.embedding_table.ids, scores, strict=True) if i not in given.names]
        by_hand = any(match.through is None for match in given.by_words(text).values())
        return None if by_hand or max(machine, default=0.0) >= PRESENT else meaning

    @cached_property
    def _last_scores(self) -> dict[str, TextScores]:
        return {}

    def _text_scores(self, text: str) -> TextScores:
        """`_scored`, once for the questions that one query asks in a row."""
        scored = self._last_scores.get(text)
        if scored is None:
            scored = self._scored(text)
            self._last_scores.clear()  # other threads may ask other things: what is here is this text's or nothing
            self._last_scores[text] = scored
        return scored

    def _scored(self, text: str) -> TextScores:
        """The probability (M,) that each instance is what a text means, by what was said of it where anything was and
        the text is a name, else by its embeddings alone; and all that competed, None where votes do not bear on it."""
        ranking = self.text_ranking
        if not len(self.embedding_table):
            return np.zeros(0), None
        scores = ranking.scores(self.known_encoder.vectors([text]))[:, 0]
        chances = self.instance_names.asked(text)
        if chances is not None:
            scores = np.where(chances.has_votes, chances.probabilities[:, 0], scores)
        return scores, chances

    def _by_name(self, text: str, threshold: float) -> Answer:
        """The instances that a text means."""
        scores, chances = self._text_scores(text)
        rows = _above(scores, threshold)
        answer = self._answer(scores, rows, threshold, self._guesses(rows))
        if chances is not None:
            hits = zip(answer.hits, rows.tolist(), strict=True)
            answer = replace(answer, hits=tuple(replace(hit, runner_up=chances.runner_up(row)) for hit, row in hits))
        return answer if not self.parts else self._with_parts_of_text(answer, text, scores)

    def _by_kind(self, meaning: NameSet, threshold: float) -> Answer:
        """The instances whose name is one of a set."""
        choices, members = self.known_encoder.choices, meaning.rows
        ranking = self.text_ranking
        if not len(self.embedding_table):
            return Answer((), threshold)
        # What is like no name at all is as much like each of them, and so like most sets of a table of few names.
        present = ranking.set_scores(choices.vectors[members])
        scores = np.minimum(self._choice_shares.set_shares(members), present)
        best = self._choice_shares.log_shares(members)
        chances = self.instance_names.asked_any(NameList([choices.names[i] for i in members], choices.vectors[members]))
        if chances is not None:
            voted = chances.has_votes
            scores = np.where(voted, chances.probabilities.sum(axis=1).clip(max=1), scores)
            best = np.where(voted[:, None], chances.probabilities, best)
        rows = _above(scores, threshold)
        best = best[rows].argmax(axis=1)
        answer = self._answer(scores, rows, threshold, self._guesses(rows))
        hits = [
            replace(hit, through=choices.names[members[number]], kind=meaning.kinds[number])
            for hit, number in zip(answer.hits, best, strict=True)
        ]
        return Answer(tuple(hits), threshold)

    @cached_property
    def _choice_shares(self) -> NameShares:
        return NameShares(self.embedding_table, self.known_encoder.choices.vectors)

    def _with_parts_of_text(self, answer: Answer, text: str, scores: Float64Array) -> Answer:
        """The same with parts that a text means rather than their wholes, which have `scores` (M,): whether by what was
        said of a whole or by its embeddings, as of parts nothing was said."""
        vector = self.known_encoder.vectors([text])
        of_wholes = np.maximum(scores, self.text_ranking.scores(vector)[:, 0])
        ranking = TextRanking(self.part_table, self.known_encoder.negatives, self.embedding_table)
        return self._with_parts(answer, ranking.scores(vector)[:, 0], of_wholes)

    def _with_parts(self, answer: Answer, scores: Float64Array, of_wholes: Float64Array) -> Answer:
        """An answer with the parts that fit better than their wholes, by the scores of `part_table` and of
        `embedding_table`."""
        part_by_id = {part.id: part for part in self.parts}
        parts = [part_by_id[int(i)] for i in self.part_table.ids]
        score_of = dict(zip(self.embedding_table.ids.tolist(), of_wholes.tolist(), strict=True))
        wholes = np.array([score_of.get(part.part_of, 0.0) for part in parts])
        rows = better_parts(scores, wholes, answer.threshold)
        hits = [Hit(parts[row], float(scores[row]), parts[row].class_name) for row in rows.tolist()]
        return _sorted(answer, [*answer.hits, *hits])

    def _with_given(self, answer: Answer, given: dict[int, GivenMatch]) -> Answer:
        """An answer in which the instances that people named score by that name."""
        hits = [hit for hit in answer.hits if hit.object.id not in self.given_names.names]
        by_id = {o.id: o for o in self.objects}
        hits += [
            Hit(by_id[i], match.score, by_id[i].class_name, match.through, match.kind)
            for i, match in sorted(given.items())
            if match.score >= answer.threshold
        ]
        return _sorted(answer, hits)

    def _guesses(self, rows: IndexArray) -> list[str | None]:
        """The negative prompt that suits each of some instances best, by their rows in `embedding_table`; None for
        those that have a class."""
        has_class = {o.id: bool(o.class_name) for o in self.objects}
        nameless = [row for row in rows.tolist() if not has_class[int(self.embedding_table.ids[row])]]
        if not nameless:
            return [None] * len(rows)
        negatives = self.known_encoder.negatives
        best = ranked_names(self.embedding_table, negatives.vectors, np.array(nameless, np.intp))
        guess = {row: negatives.names[number] for row, number in zip(nameless, best[:, 0], strict=True)}
        return [guess.get(row) for row in rows.tolist()]

    def _check(self, dimension: int) -> None:
        own = self.embedding_table.vectors.shape[1]
        if len(self.embedding_table) and own != dimension:
            raise BadInput(
                f"the embedder makes vectors of {dimension} numbers, but those of this map have {own}: "
                "name the embedder that made them with --embedder and --set"
            )

    def _answer(
        self, scores: Float64Array, rows: IndexArray, threshold: float, guesses: Sequence[str | None]
    ) -> Answer:
        known = {o.id: o for o in self.objects}
        matches = [known[int(i)] for i in self.embedding_table.ids[rows]]
        hits = [
            Hit(o, float(score), o.class_name or guess)
            for o, score, guess in zip(matches, scores[rows], guesses, strict=True)
        ]
        return Answer(tuple(hits), threshold)


def _above(scores: Float64Array, threshold: float) -> IndexArray:
    """Rows of the scores (M,) that reach a threshold, the best first."""
    order = np.argsort(-scores, kind="stable")
    return order[scores[order] >= threshold]


def _sorted(answer: Answer, hits: Sequence[Hit]) -> Answer:
    return replace(answer, hits=tuple(sorted(hits, key=lambda hit: -hit.score)))
