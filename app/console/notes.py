"""Notes on a result: what one should know of it, beside the result itself."""

from __future__ import annotations

from collections.abc import Iterable

from rich.console import Console


def print_notes(notes: Iterable[str], console: Console) -> None:
    """One line for each note."""
    for note in notes:
        console.print(f"note: {note}", soft_wrap=True)
