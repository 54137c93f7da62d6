"""Progress on standard error: a live bar, or lines where there is no terminal."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from typing import TypeVar

from rich.console import Console
from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeRemainingColumn

T = TypeVar("T")

TENTHS = 10


def show_progress(
    items: Iterable[T], total: int, status: Callable[[], str], console: Console, *, done: int = 0
) -> Iterator[T]:
    """Pass `items` on while showing how many are done: a live bar on a terminal, else a line each tenth of the way.

    Args:
        items: what is worked through; an item is done when the next one is asked for.
        total: how many there are to be shown; what comes after them is not counted.
        status: returns the text that is shown beside.
        console: where it is shown.
        done: how many were done before these.
    """
    show = _bar if console.is_terminal else _lines
    return show(items, total, status, console, done)


def _bar(items: Iterable[T], total: int, status: Callable[[], str], console: Console, before: int) -> Iterator[T]:
    columns = (BarColumn(), MofNCompleteColumn(), TextColumn("{task.description}"), TimeRemainingColumn())
    with Progress(*columns, console=console, refresh_per_second=4) as bar:
        task = bar.add_task(status(), total=total, completed=before)
        for done, item in enumerate(items, start=before + 1):
            yield item
            bar.update(task, completed=min(done, total), description=status())


def _lines(items: Iterable[T], total: int, status: Callable[[], str], console: Console, before: int) -> Iterator[T]:
    tenth = TENTHS * before // max(total, 1)
    for done, item in enumerate(items, start=before + 1):
        yield item
        if (now := TENTHS * min(done, total) // total) > tenth:
            tenth = now
            console.print(f"{done}/{total} frames, {status()}", soft_wrap=True)
