"""Standard output for results, standard error for everything else."""

from __future__ import annotations

from collections.abc import Iterable

from rich.console import Console


def result_console() -> Console:
    """Where results go; square brackets in file names are not markup."""
    return Console(markup=False, highlight=False)


def progress_console() -> Console:
    """Where progress and warnings go."""
    return Console(stderr=True, markup=False, highlight=False)


def print_notes(notes: Iterable[str]) -> None:
    """What one should know of a result, on standard error."""
    for note in notes:
        progress_console().print(f"note: {note}", soft_wrap=True)


def print_warnings(warnings: Iterable[str]) -> None:
    """What makes a result doubtful, on standard error."""
    for warning in warnings:
        progress_console().print(f"WARNING: {warning}", style="bold red", soft_wrap=True)
