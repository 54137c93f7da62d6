"""Class vocabularies of datasets: names with their numbers, and which of them are stuff."""

from __future__ import annotations

import csv
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property, lru_cache
from pathlib import Path

from razer.errors import BadInput
from razer.files import MALFORMED, read_text

MAX_ID = 2**31 - 1  # what meshes hold
FOLDER = Path(__file__).with_name("vocabularies")
VOCABULARIES = tuple(sorted(path.stem for path in FOLDER.glob("*.csv")))


@dataclass(frozen=True, slots=True)
class Category:
    """One class: its number and name in the list, its number among the NYU40 classes (0 = none), the group that
    results are split by ("head", "common", "tail" of ScanNet200, else empty), and whether it is stuff."""

    id: int
    name: str
    nyu40: int
    group: str
    stuff: bool


@dataclass(frozen=True)
class Vocabulary:
    """A named list of classes; numbers and names are unique."""

    name: str
    categories: tuple[Category, ...]

    def __post_init__(self) -> None:
        for what in ("id", "name"):
            values = [getattr(category, what) for category in self.categories]
            if len(set(values)) < len(values):
                raise BadInput(f"vocabulary {self.name} has one {what} twice: each may stand there once")

    @cached_property
    def by_name(self) -> Mapping[str, Category]:
        """The categories by name."""
        return {category.name: category for category in self.categories}

    @cached_property
    def by_id(self) -> Mapping[int, Category]:
        """The categories by number."""
        return {category.id: category for category in self.categories}

    @property
    def names(self) -> tuple[str, ...]:
        """All names in the order of the list."""
        return tuple(category.name for category in self.categories)


@lru_cache(maxsize=16)
def vocabulary(name: str) -> Vocabulary:
    """One of VOCABULARIES, or a file: a .csv with columns id, name and optionally nyu40, group, stuff, or a text
    with one name a line, numbered from 1. Raises BadInput.

    Sources: scannet200, scannet20, nyu40: the label map and the ScanNet200 splits that ScanNet publishes;
    replica: the classes in each info_semantic.json of Replica, with NYU40 numbers by ScanNet's label map; coco, lvis:
    the categories of their annotations (LVIS v1), all of them things."""
    path = FOLDER / f"{name}.csv" if name in VOCABULARIES else Path(name)
    try:
        text = read_text(path)
    except BadInput as error:
        problem = f"{name} is no vocabulary ({error})"
        raise BadInput(f"{problem}: give one of {', '.join(VOCABULARIES)}, or a file") from None
    try:
        rows = list(csv.DictReader(text.splitlines())) if path.suffix == ".csv" else _numbered(text)
        categories = tuple(_category(row) for row in rows)
    except (*MALFORMED, csv.Error):
        raise BadInput(
            f"{path} needs the columns id and name, with a name in each row, and numbers in id and nyu40"
        ) from None
    try:
        return Vocabulary(path.stem, categories)
    except BadInput as error:
        raise BadInput(f"{path}: {error}") from None


def _numbered(text: str) -> list[dict[str, str]]:
    names = [line.strip() for line in text.splitlines() if line.strip()]
    return [{"id": str(number), "name": name} for number, name in enumerate(names, start=1)]


def _category(row: Mapping[str, str]) -> Category:
    stuff, number = bool(int(row.get("stuff") or 0)), int(row["id"])
    if not (row["name"] or "").strip() or not 0 <= number <= MAX_ID:
        raise ValueError
    return Category(number, row["name"], int(row.get("nyu40") or 0), row.get("group") or "", stuff)
