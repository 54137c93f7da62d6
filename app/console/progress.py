"""Live progress on standard error: frames a second, instances, memory."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from typing import TypeVar

from rich.console import Console
from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeRemainingColumn

T = TypeVar("T")

TENTHS = 10


def watch(items: Iterable[T], total: int, status: Callable[[], str], console: Console) -> Iterator[T]:
    """Pass `items` on while showing how far it is, with the text of `status` beside it.

    A terminal gets a live bar; anything else gets one line each tenth of the way.
    """
    return _bar(items, total, status, console) if console.is_terminal else _lines(items, total, status, console)


def _bar(items: Iterable[T], total: int, status: Callable[[], str], console: Console) -> Iterator[T]:
    columns = (BarColumn(), MofNCompleteColumn(), TextColumn("{task.description}"), TimeRemainingColumn())
    with Progress(*columns, console=console, refresh_per_second=4) as bar:
        task = bar.add_task(status(), total=total)
        for item in items:
            yield item
            bar.update(task, advance=1, description=status())


def _lines(items: Iterable[T], total: int, status: Callable[[], str], console: Console) -> Iterator[T]:
    tenth = 0
    for done, item in enumerate(items, start=1):
        yield item
        if (now := TENTHS * min(done, total) // total) > tenth:
            tenth = now
            console.print(f"{done}/{total} frames, {status()}", soft_wrap=True)
