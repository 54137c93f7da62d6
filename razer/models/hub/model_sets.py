"""Sets of catalogue entries that are fetched together."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from difflib import get_close_matches
from types import MappingProxyType

from razer.errors import BadInput
from razer.models.hub.catalogue import CatalogueEntry, entry


@dataclass(frozen=True)
class ModelSet:
    """Several entries under one name."""

    name: str
    about: str
    members: tuple[str, ...]

    @property
    def entries(self) -> tuple[CatalogueEntry, ...]:
        """Its entries, in order."""
        return tuple(entry(name) for name in self.members)

    @property
    def megabytes(self) -> int:
        """Size of all together, units of 10^6 bytes."""
        return sum(each.megabytes for each in self.entries)


STARTER = ModelSet(
    "starter",
    "things, walls and floors by name, and words to ask by; everyone may use it for anything",
    ("rf-detr-seg-small", "upernet-convnext-tiny", "clip-vit-b32"),
)
MODEL_SETS: Mapping[str, ModelSet] = MappingProxyType({STARTER.name: STARTER})


def entries_of(name: str) -> tuple[CatalogueEntry, ...]:
    """The entries of a set, or the one entry of that name; raises BadInput that names the nearest ones."""
    if name not in MODEL_SETS and (near := get_close_matches(name, MODEL_SETS, 1)):
        raise BadInput(f"no set of models '{name}': did you mean {near[0]}? 'razer models list' has all")
    return MODEL_SETS[name].entries if name in MODEL_SETS else (entry(name),)
