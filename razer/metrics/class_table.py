"""Class name normalisation: truth and prediction may take their names from different label sets."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from functools import cached_property, lru_cache

from razer.vocabulary import VOCABULARIES, Vocabulary, vocabulary

FROM_TRUTH = "truth"

# Names that the lists in use give to one and the same class.
_SYNONYMS = (
    ("sofa", "couch"),
    ("refridgerator", "refrigerator", "fridge"),
    ("television", "tv", "tv screen"),
    ("books", "book"),
    ("night stand", "nightstand"),
    ("shelves", "shelf"),
    ("counter", "countertop"),
    ("otherfurniture", "other furniture"),
    ("potted plant", "indoor plant"),
)


def normalized_name(name: str) -> str:
    """A name as it is compared: lower case, words separated by single spaces."""
    return " ".join(name.lower().replace("-", " ").replace("_", " ").split())


@dataclass(frozen=True)
class ClassTable:
    """The classes of one scene: number >= 1 -> name, and group -> names where the list has groups."""

    names: Mapping[int, str]
    groups: Mapping[str, str]

    @classmethod
    def of(cls, vocabulary_name: str, truth_names: Mapping[int, str]) -> ClassTable:
        """The list of that name, or, for "truth", the names that the truth itself bears. Raises BadInput."""
        if vocabulary_name == FROM_TRUTH:
            return cls({number: name for number, name in sorted(truth_names.items()) if number > 0}, {})
        return cls(*_from_list(vocabulary(vocabulary_name)))

    def number(self, name: str) -> int:
        """The class a name stands for, 0 for none: the class of that name, or of another name for the same thing, or
        the NYU40 class that one of the known lists sorts the name under, if this list has that class."""
        key = normalized_name(name)
        if key in self._numbers:
            return self._numbers[key]
        for synonym in _synonyms(key):
            if synonym in self._numbers:
                return self._numbers[synonym]
        coarse = _nyu40_name(key)
        return self.number(coarse) if coarse and coarse != key else 0

    def numbers(self, names: Mapping[int, str]) -> dict[int, int]:
        """The class of each named id; ids whose name is unknown are left out."""
        classes = {instance: self.number(name) for instance, name in names.items()}
        return {instance: number for instance, number in classes.items() if number}

    def subset(self, names: Iterable[str], all_if_empty: bool = False) -> set[int]:
        """The numbers of some names, as far as the table has them; of no names none, or all with `all_if_empty`."""
        names = tuple(names)
        if not names and all_if_empty:
            return set(self.names)
        return {self.number(name) for name in names} - {0}

    @cached_property
    def _numbers(self) -> dict[str, int]:
        # Of two numbers with one name the lower stands for both.
        return {normalized_name(name): number for number, name in sorted(self.names.items(), reverse=True)}


def _from_list(listed: Vocabulary) -> tuple[dict[int, str], dict[str, str]]:
    names = {category.id: category.name for category in listed.categories if category.id > 0}
    return names, {category.name: category.group for category in listed.categories if category.group}


def _synonyms(name: str) -> tuple[str, ...]:
    return next((group for group in _SYNONYMS if name in group), ())


@lru_cache(maxsize=4096)
def _nyu40_name(name: str) -> str:
    """The NYU40 class that a list of ours sorts a name under, "" if none does."""
    nyu40 = vocabulary("nyu40").by_id
    for listed in VOCABULARIES:
        for category in vocabulary(listed).categories:
            if normalized_name(category.name) == name and category.nyu40 in nyu40:
                return nyu40[category.nyu40].name
    return ""
