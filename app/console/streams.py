"""Standard output for results, standard error for everything else."""

from __future__ import annotations

import os
from collections.abc import Iterable
from typing import Any

from rich.console import Console
from rich.text import Text

from app.console.printable import printable

QUIET = "RAZER_QUIET"  # in the environment, for helper processes too


class PlainConsole(Console):
    """A console that says texts as they are: square brackets are no markup, :names: no pictures, and a terminal obeys
    nothing in them, as names in files may have been chosen by somebody who means harm."""

    def __init__(self, *, stderr: bool = False, quiet: bool = False) -> None:
        super().__init__(stderr=stderr, quiet=quiet, markup=False, highlight=False, emoji=False)

    def render_str(self, text: str, **options: Any) -> Text:
        """A text to be shown, with escapes for control characters."""
        return super().render_str(printable(text), **options)


def result_console() -> Console:
    """Where results go."""
    return PlainConsole()


def progress_console() -> Console:
    """Where progress and notes go; nowhere with --quiet."""
    return PlainConsole(stderr=True, quiet=bool(os.environ.get(QUIET)))


def print_notes(notes: Iterable[str]) -> None:
    """What one should know of a result, on standard error."""
    for note in notes:
        progress_console().print(f"note: {note}", soft_wrap=True)


def print_warnings(warnings: Iterable[str]) -> None:
    """What makes a result doubtful, on standard error."""
    for warning in warnings:
        console = PlainConsole(stderr=True)
        console.print(f"WARNING: {warning}", style="bold red", soft_wrap=True)
