"""Kinds of things and what they are good for, by a table of hypernyms: what a word stands for among class names.

A text encoder knows that a couch is furniture; a table of names does not. docs/queries.md tells where the table of
kinds comes from and how right it is.
"""

from __future__ import annotations

import difflib
import tomllib
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from razer.arrays import IndexArray
from razer.query.phrases import alternatives, plain, singulars, verb_forms, without_openings, without_particles
from razer.vocabulary import FOLDER

_FILE = FOLDER / "kinds.toml"
_NEAR = 0.7  # difflib's ratio from which a word looks like a slip of another


@dataclass(frozen=True)
class Kind:
    """A kind of thing: what else it is called, what it is good for, and the class names that belong to it."""

    name: str
    called: tuple[str, ...]
    purposes: tuple[str, ...]
    names: tuple[str, ...]

    @property
    def words(self) -> tuple[str, ...]:
        """Its name and what else it is called."""
        return (self.name, *self.called)


@dataclass(frozen=True)
class NameSet:
    """Some names of a list, by their rows (K,) in it, and the kind as which each is meant, None for itself."""

    rows: IndexArray
    kinds: tuple[str | None, ...]


@lru_cache(maxsize=1)
def all_kinds() -> tuple[Kind, ...]:
    """The table of kinds."""
    table = tomllib.loads(_FILE.read_text(encoding="utf-8"))
    return tuple(
        Kind(name, *(tuple(entry.get(part, ())) for part in ("called", "purposes", "names")))
        for name, entry in table.items()
    )


def near_kinds(text: str, n: int = 3) -> list[str]:
    """The names of at most n kinds whose words look like a text."""
    words = {plain(word): kind.name for kind in all_kinds() for word in kind.words}
    near = [match for form in singulars(plain(text)) for match in difflib.get_close_matches(form, words, n, _NEAR)]
    return list(dict.fromkeys(words[word] for word in near))[:n]


def expand(text: str, names: Sequence[str]) -> NameSet | None:
    """The names that a text stands for: names in the plural, kinds ("furniture"), purposes ("something to sit on"), or
    several with "and" or "or" between; None where a part of the text is none of these, and for a name itself, unless it
    is a kind's, too. A kind that none of the names belongs to gives an empty set.

    Args:
        text: what is asked for.
        names: (N,) those that there are to choose from.
    """
    rows = _rows(tuple(names))
    for parts in ([text], alternatives(text)):
        meant = [_meaning(part, rows) for part in parts]
        known = [each for each in meant if each is not None]
        if known and len(known) == len(meant):
            found = {row: kind for each in reversed(known) for row, kind in each.items()}
            if found == {rows.get(plain(text)): None}:
                return None
            ordered = sorted(found)
            return NameSet(np.array(ordered, np.intp), tuple(found[row] for row in ordered))
    return None


@lru_cache(maxsize=4)
def _rows(names: tuple[str, ...]) -> Mapping[str, int]:
    """The row of each name; of equal ones the first."""
    return {plain(name): row for row, name in reversed(list(enumerate(names)))}


def _meaning(text: str, rows: Mapping[str, int]) -> dict[int, str | None] | None:
    """The rows of the names that one phrase stands for, each with its kind."""
    for phrase, verb_follows in without_openings(plain(text)):
        forms = singulars(phrase)
        named: dict[int, str | None] = {rows[form]: None for form in forms if form in rows}
        # What a kind is called besides is not always true of all its names: a shelf may be no bookcase.
        kinds = _first(_by_name(), forms) or (() if named else _first(_by_word(), forms))
        if not verb_follows and (named or kinds):
            return _members(kinds, rows) | named
        # A single word is a verb only where one must follow: "water" is none.
        is_verb = verb_follows or " " in phrase or phrase.endswith("ing")
        if is_verb and (kinds := _first(_by_purpose(), without_particles(phrase))):
            return _members(kinds, rows)
    return None


def _first(table: Mapping[str, tuple[Kind, ...]], phrases: Sequence[str] | Iterator[str]) -> tuple[Kind, ...]:
    return next((table[phrase] for phrase in phrases if phrase in table), ())


def _members(kinds: Sequence[Kind], rows: Mapping[str, int]) -> dict[int, str | None]:
    """The rows of the names of some kinds; a name of several counts as the first."""
    found: dict[int, str | None] = {}
    for kind in kinds:
        for name in map(plain, (*kind.names, *kind.words)):
            if name in rows:
                found.setdefault(rows[name], kind.name)
    return found


@lru_cache(maxsize=1)
def _by_name() -> Mapping[str, tuple[Kind, ...]]:
    """Each kind by its own name."""
    return {plain(kind.name): (kind,) for kind in all_kinds()}


@lru_cache(maxsize=1)
def _by_word() -> Mapping[str, tuple[Kind, ...]]:
    """The kind that each other word asks for."""
    return {plain(word): (kind,) for kind in all_kinds() for word in kind.called}


@lru_cache(maxsize=1)
def _by_purpose() -> Mapping[str, tuple[Kind, ...]]:
    """The kinds that serve each purpose."""
    table: dict[str, tuple[Kind, ...]] = {}
    for kind in all_kinds():
        for form in (form for purpose in kind.purposes for form in verb_forms(plain(purpose))):
            table[form] = (*table.get(form, ()), kind)
    return table
