"""Standard output for results, standard error for everything else."""

from __future__ import annotations

import os
from collections.abc import Iterable

from rich.console import Console

QUIET = "RAZER_QUIET"  # in the environment, for helper processes too


def result_console() -> Console:
    """Where results go; square brackets in file names are not markup."""
    return Console(markup=False, highlight=False)


def progress_console() -> Console:
    """Where progress and notes go; nowhere with --quiet."""
    return Console(stderr=True, markup=False, highlight=False, quiet=bool(os.environ.get(QUIET)))


def print_notes(notes: Iterable[str]) -> None:
    """What one should know of a result, on standard error."""
    for note in notes:
        progress_console().print(f"note: {note}", soft_wrap=True)


def print_warnings(warnings: Iterable[str]) -> None:
    """What makes a result doubtful, on standard error."""
    for warning in warnings:
        console = Console(stderr=True, markup=False, highlight=False)
        console.print(f"WARNING: {warning}", style="bold red", soft_wrap=True)
