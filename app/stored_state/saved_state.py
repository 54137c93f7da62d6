"""Which files hold the state of a process."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from app.stored_state.array_packs import number_of, remove_packs


@dataclass(frozen=True)
class SavedState:
    """A state in a folder: the name of its process, which tree is its, and the packs that it needs."""

    name: str
    number: int
    packs: tuple[int, ...]


def tree_path(folder: Path, name: str, number: int) -> Path:
    """The file of a tree."""
    return folder / f"{name}-{number}.json"


def tidy(folder: Path, saved: SavedState) -> None:
    """Remove what was written for earlier states alone."""
    remove_packs(folder, saved.name, saved.packs)
    for path in folder.glob(f"{saved.name}-*.json"):
        if number_of(path) < saved.number:
            path.unlink(missing_ok=True)
