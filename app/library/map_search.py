"""Search of a library: the nearest vectors and the right names tell which maps to ask, and each of these answers as
`razer query` does."""

from __future__ import annotations

import threading
from collections import OrderedDict
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass

import pyarrow as pa

from app.library.known_texts import KnownTexts
from app.library.presence import picture_threshold_among, threshold_among
from app.library.tables.instance_library import InstanceTable, any_of
from app.library.tables.stored_map import COLUMNS, StoredMap
from razer.arrays import Float32Array
from razer.errors import BadInput
from razer.map_object import Answer, Hit
from razer.query.phrases import plain, singulars
from razer.query.ranking import PRESENT

_ROWS_EXACT, _ROWS_INDEXED = 2000, 200  # nearest vectors that are looked at, without and with an index
_MAPS, _MAPS_OF_PICTURE, _MAPS_KEPT = 8, 16, 512  # that are asked by looks and as many by name, and that are kept open
Ask = Callable[[StoredMap, float], Answer]


@dataclass(frozen=True)
class Wanted:
    """What of a search is wanted: k hits at most, of instances that pass a filter, above a least score (None: what is
    right for as many maps as are asked, see `threshold_among`); not: (run, id) that is no hit."""

    k: int = 5
    where: str | None = None
    min_score: float | None = None
    not_this: tuple[str, int] | None = None


@dataclass(frozen=True)
class LibraryHit:
    """An instance of a map in a library."""

    run: str
    scene: str
    hit: Hit


@dataclass(frozen=True)
class LibraryAnswer:
    """Hits, the most probable first, out of `n_asked` instances; nothing that was found by its looks scores less than
    `threshold`."""

    hits: tuple[LibraryHit, ...]
    threshold: float
    n_asked: int

    @property
    def found(self) -> bool:
        """Whether what was asked for is in any of the maps."""
        return bool(self.hits)


class MapSearch:
    """Answers from one table; maps that were asked are kept for the next question. Safe from several threads."""

    def __init__(self, table: InstanceTable, encoder: KnownTexts | None) -> None:
        """`encoder`: of the model of the table, None where only vectors are asked for."""
        self.table, self.encoder = table, encoder
        self._maps: OrderedDict[str, StoredMap] = OrderedDict()
        self._lock = threading.Lock()

    def by_text(self, text: str, wanted: Wanted) -> LibraryAnswer:
        """The instances that a text means; raises BadInput where the embedder cannot tell."""
        assert self.encoder is not None
        n_asked, threshold = self._threshold(wanted, threshold_among)
        least = PRESENT if wanted.min_score is None else wanted.min_score  # of what is known by its name
        vectors, names, problem = self._meant(text)
        maps = self._candidates(vectors, names, wanted, _MAPS)
        answers, problems = [], [problem] if problem else []
        for each in maps:
            try:
                answers.append((each, each.queries.by_text(text, least)))
            except BadInput as error:
                problems.append(error)
        if problems and not answers:
            raise problems[0]
        return self._merged(answers, wanted, threshold, n_asked)

    def by_vector(self, vector: Float32Array, wanted: Wanted) -> LibraryAnswer:
        """The instances that look like a vector (D,) of a picture; raises BadInput for one of another length."""
        if len(vector) != self.table.model.dimension:
            raise BadInput(
                f"the vector has {len(vector)} numbers, those of table {self.table.model.table} have "
                f"{self.table.model.dimension}"
            )
        n_asked, threshold = self._threshold(wanted, picture_threshold_among)
        maps = self._candidates(vector[None], (), wanted, _MAPS_OF_PICTURE)
        answers = [(each, each.queries.by_image(vector, threshold)) for each in maps]
        return self._merged(answers, wanted, threshold, n_asked)

    def opened(self, runs: Iterable[str]) -> list[StoredMap]:
        """Some maps, as they were added last; those that are not there are left out."""
        asked = list(runs)
        rows = self.table.rows_of(asked, COLUMNS)
        found = {run: StoredMap.of(rows[run], self.encoder) for run in asked if run in rows}
        with self._lock:
            for run, each in found.items():
                self._maps[run] = each
                self._maps.move_to_end(run)
            while len(self._maps) > _MAPS_KEPT:
                self._maps.popitem(last=False)
        return list(found.values())

    def _meant(self, text: str) -> tuple[Float32Array | None, tuple[str, ...], BadInput | None]:
        """The vectors and the forms of the names that a text stands for; why there is no vector, where there is none:
        somebody may have given an instance that name by hand."""
        assert self.encoder is not None
        forms = tuple(singulars(plain(text)))
        try:
            meaning = self.encoder.meaning(text)
            if meaning is None:
                return self.encoder.query_vector(text), forms, None
            choices = self.encoder.choices
            named = (plain(choices.names[row]) for row in meaning.rows)
            return choices.vectors[meaning.rows], (*forms, *named), None
        except BadInput as error:
            return None, forms, error

    def _threshold(self, wanted: Wanted, among: Callable[[float], float]) -> tuple[int, float]:
        """How many instances are asked, and the least score of a hit by its looks."""
        n_asked = self.table.count(wanted.where)
        n_maps = self.table.n_maps() * n_asked / max(self.table.count(), 1)
        return n_asked, among(n_maps) if wanted.min_score is None else wanted.min_score

    def _candidates(
        self, vectors: Float32Array | None, names: Sequence[str], wanted: Wanted, n_maps: int
    ) -> list[StoredMap]:
        """The maps of the rows that are nearest, of all and of those called so."""
        found = []
        if vectors is not None:
            found.append(self._nearest(vectors, wanted.where, wanted.k))
        if any(names):
            called = any_of(names) if wanted.where is None else f"({wanted.where}) AND {any_of(names)}"
            found.append(self._called(called, vectors, wanted.k))
        newest: dict[str, int] = {}
        for rows in found:
            for run, generation in _first_runs(rows, max(n_maps, 2 * wanted.k)):
                newest[run] = max(generation, newest.get(run, 0))
        return self._current(newest)

    def _nearest(self, vectors: Float32Array, where: str | None, k: int) -> pa.Table:
        n = _ROWS_INDEXED if self.table.table.has_index() else _ROWS_EXACT
        each = max(n, 20 * k) // len(vectors) + 1
        return self.table.nearest(vectors, each, where, self.table.width(each)).sort_by("_distance")

    def _called(self, where: str, vectors: Float32Array | None, k: int) -> pa.Table:
        if vectors is None:
            return self.table.table.rows(where, ("run", "generation"), max(_ROWS_INDEXED, 20 * k))
        return self._nearest(vectors, where, k)

    def _current(self, newest: dict[str, int]) -> list[StoredMap]:
        """Maps that are at least as new as the generations that were seen of them."""
        known = {run: self._maps.get(run) for run in newest}
        fresh = {run: each for run, each in known.items() if each is not None and each.generation >= newest[run]}
        opened = self.opened(run for run in newest if run not in fresh)
        return [*fresh.values(), *opened]

    def _merged(
        self, answers: Sequence[tuple[StoredMap, Answer]], wanted: Wanted, threshold: float, n_asked: int
    ) -> LibraryAnswer:
        hits = [
            LibraryHit(each.run, each.scene, hit)
            for each, answer in answers
            for hit in answer.hits
            if (each.run, hit.object.id) != wanted.not_this and (hit.score >= threshold or _is_named(hit))
        ]
        hits.sort(key=lambda each: (-each.hit.score, each.run, each.hit.object.id))
        return LibraryAnswer(tuple(self._passing(hits, wanted)), threshold, n_asked)

    def _passing(self, hits: list[LibraryHit], wanted: Wanted) -> list[LibraryHit]:
        """The first hits that pass the filter."""
        if wanted.where is None or not hits:
            return hits[: wanted.k]
        runs = list(dict.fromkeys(each.run for each in hits))
        rows = self.table.rows_of(runs, ("run", "generation", "id"), wanted.where)
        passing = {(run, i) for run, own in rows.items() for i in own["id"].to_pylist()}
        return [each for each in hits if (each.run, each.hit.object.id) in passing][: wanted.k]


def _first_runs(rows: pa.Table, n: int) -> list[tuple[str, int]]:
    """The first n runs that rows are of, each with the newest generation among these rows."""
    newest: dict[str, int] = {}
    for run, generation in zip(rows["run"].to_pylist(), rows["generation"].to_pylist(), strict=True):
        if run in newest or len(newest) < n:
            newest[run] = max(generation, newest.get(run, 0))
    return list(newest.items())


def _is_named(hit: Hit) -> bool:
    """Whether a hit follows from what somebody said of it, and not from its looks alone."""
    return bool(hit.object.class_votes) or hit.object.is_named_by_hand
