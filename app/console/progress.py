"""Progress on standard error: a live bar, or lines where there is no terminal."""

from __future__ import annotations

import sys
from collections.abc import Callable, Iterable, Iterator
from itertools import chain, islice
from time import monotonic
from typing import TypeVar

from rich.console import Console
from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeRemainingColumn
from rich.table import Column

from app.console.waiting import AGAIN_S, is_live, waiting_for

T = TypeVar("T")

TENTHS = 10
_NARROW = 80  # columns of a terminal below which the bar is short, so that what stands beside it can be read


def show_progress(
    items: Iterable[T],
    total: int,
    status: Callable[[], str],
    console: Console,
    *,
    first: str = "starting",
    things: str = "frames",
    done: int = 0,
) -> Iterator[T]:
    """Pass `items` on while showing how many are done: a live bar on a terminal, else a line each tenth of the way, and
    every ten seconds where that takes long.

    Args:
        items: what is worked through; an item is done when the next one is asked for.
        total: how many there are to be shown; what comes after them is not counted.
        status: returns the text that is shown beside.
        console: where it is shown.
        first: what is waited for until the first item is there.
        things: what the items are, where they are told in lines.
        done: how many were done before these.
    """
    if is_live(console):
        return _bar(items, total, status, console, first, done)
    return _lines(items, total, lambda: f"{things}, {status()}", console, first, done)


def _bar(
    items: Iterable[T], total: int, status: Callable[[], str], console: Console, first: str, before: int
) -> Iterator[T]:
    text = TextColumn("{task.description}", table_column=Column(no_wrap=True, overflow="ellipsis", ratio=1))
    columns = (BarColumn(8 if console.width < _NARROW else 40), MofNCompleteColumn(), TimeRemainingColumn(), text)
    # Results on a standard output that is a file must not be drawn on the terminal of standard error.
    shared = sys.stdout.isatty()
    with Progress(*columns, console=console, refresh_per_second=4, redirect_stdout=shared, expand=True) as bar:
        task = bar.add_task(first, total=total, completed=before)
        for done, item in enumerate(items, start=before + 1):
            bar.update(task, description=status())
            yield item
            bar.update(task, completed=min(done, total), description=status())


def _lines(
    items: Iterable[T], total: int, status: Callable[[], str], console: Console, first: str, before: int
) -> Iterator[T]:
    waited, tenth = iter(items), TENTHS * before // max(total, 1)
    with waiting_for(first, console):
        ready = list(islice(waited, 1))
    told_s = monotonic()
    for done, item in enumerate(chain(ready, waited), start=before + 1):
        yield item
        now = TENTHS * min(done, total) // total
        if now > tenth or monotonic() - told_s > AGAIN_S:
            tenth, told_s = now, monotonic()
            console.print(f"{done}/{total} {status()}", soft_wrap=True)
