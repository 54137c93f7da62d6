"""What a verb waits for, where nobody can say how far it is: a spinner, or a line now and then without a terminal."""

from __future__ import annotations

import sys
from collections.abc import Iterator
from contextlib import contextmanager
from threading import Event, Thread
from time import monotonic

from rich.console import Console
from rich.progress import Progress, SpinnerColumn, TextColumn, TimeElapsedColumn
from rich.table import Column

from app.console.streams import progress_console

FIRST_S, AGAIN_S = 1.0, 10.0  # seconds until the first line, and from line to line
_is_shown = False


def is_live(console: Console) -> bool:
    """Whether lines can be drawn anew where they stand."""
    return console.is_terminal and not console.is_dumb_terminal


@contextmanager
def waiting_for(what: str, console: Console | None = None, *, at_once: bool = False) -> Iterator[None]:
    """Within this context, `what` is shown as what is waited for, with the seconds so far.

    On a terminal a spinner, gone at the end; elsewhere a line after a second, and one every ten. Quiet consoles show
    nothing, nor does a wait within a wait. What is printed meanwhile stands above.

    Args:
        what: such as "aligning the maps".
        console: where it is shown; standard error if not given.
        at_once: say it without waiting for a second, for work that lets no other thread run.
    """
    global _is_shown
    console = console or progress_console()
    if console.quiet or _is_shown:
        yield
        return
    _is_shown = True
    try:
        with _spinner(what, console) if is_live(console) else _lines(what, console, at_once):
            yield
    finally:
        _is_shown = False


@contextmanager
def _spinner(what: str, console: Console) -> Iterator[None]:
    text = TextColumn("{task.description}", table_column=Column(no_wrap=True, overflow="ellipsis"))
    # Results on a standard output that is a file must not be drawn on the terminal of standard error.
    shared = sys.stdout.isatty()
    columns = (SpinnerColumn("line"), TimeElapsedColumn(), text)
    with Progress(*columns, console=console, transient=True, refresh_per_second=4, redirect_stdout=shared) as shown:
        shown.add_task(what, total=None)
        yield


@contextmanager
def _lines(what: str, console: Console, at_once: bool) -> Iterator[None]:
    is_over, began_s = Event(), monotonic()

    def say() -> None:
        pause_s = AGAIN_S if at_once else FIRST_S
        while not is_over.wait(pause_s):
            passed_s = monotonic() - began_s
            since = f" ({passed_s:.0f} s)" if pause_s > FIRST_S else ""
            console.print(f"{what} ...{since}", soft_wrap=True)
            pause_s = AGAIN_S

    if at_once:
        console.print(f"{what} ...", soft_wrap=True)
    teller = Thread(target=say, daemon=True)
    teller.start()
    try:
        yield
    finally:
        is_over.set()
        teller.join()
