"""What a child process remarks: its user is told, as if it had been said here."""

from __future__ import annotations

from collections.abc import Iterable

from app.console.streams import print_notes, print_warnings

_SAID_BY = {"note: ": print_notes, "WARNING: ": print_warnings}


def notes_of(log: str) -> tuple[str, ...]:
    """The notes and warnings in what a process said, a line each, none twice."""
    return tuple(dict.fromkeys(line for line in log.splitlines() if line.startswith((*_SAID_BY,))))


def tell_notes(name: str, notes: Iterable[str]) -> None:
    """Print notes as `notes_of` has them, with the name of what they are about."""
    for note in notes:
        for kind, say in _SAID_BY.items():
            if note.startswith(kind):
                say([f"{name}: {note.removeprefix(kind)}"])
