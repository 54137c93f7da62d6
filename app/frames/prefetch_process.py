"""Prefetching in a process of its own, in order.

A thread would not do: perceiving a frame is many small array operations that hold the interpreter's lock, and two
threads take turns at it (on two cores a kitchen ran at 6 frames a second with a thread, at 8 with a process).
"""

from __future__ import annotations

import signal
import sys
from collections.abc import Callable, Generator, Iterable
from contextlib import closing, suppress
from multiprocessing import get_context
from multiprocessing.connection import Connection
from queue import SimpleQueue
from threading import Thread
from typing import Any, TypeVar

from app.console.plain_warnings import warn_in_one_line

S = TypeVar("S")
T = TypeVar("T")
HUNG_UP = object()


def prefetch(work: Callable[[S], T], items: Iterable[S], depth: int = 2) -> Generator[T]:
    """`work(item)` for each item, in order, at most `depth` of them asked for before they are needed.

    `work`, items and what is made of them travel by pickle. What `work` raises is raised here, at that item's turn.
    """
    context = get_context("spawn")
    ours, theirs = context.Pipe()
    process = context.Process(target=_serve, args=(theirs, work), name="prefetch", daemon=True)
    process.start()
    theirs.close()
    n_sent = n_received = 0
    try:
        with closing(ours):
            for n_sent, item in enumerate(items, start=1):
                ours.send(item)
                if n_sent - n_received > depth:
                    yield _received(ours, n_received)
                    n_received += 1
            while n_received < n_sent:
                yield _received(ours, n_received)
                n_received += 1
    finally:
        # It ends by itself once the pipe is closed; one busy with a frame nobody waits for need not finish it.
        process.join(0.2)
        process.terminate()
        process.join()


def _received(connection: Connection, number: int) -> Any:
    try:
        succeeded, result = connection.recv()
    except (EOFError, ConnectionResetError):
        raise RuntimeError(f"a prefetch process ended while it worked on its item {number}") from None
    if succeeded:
        return result
    raise result


def _serve(connection: Connection, work: Callable[[Any], Any]) -> None:
    """Answer items until the other side hangs up, also because its process was killed."""
    warn_in_one_line()
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # Ctrl-C goes to the whole group, and is the parent's to handle
    items: SimpleQueue[Any] = SimpleQueue()
    # Taken in at once: two sides that both send what fills the pipe would wait for each other.
    Thread(target=_receive, args=(connection, items), daemon=True).start()
    while (item := items.get()) is not HUNG_UP:
        answer = _answer(work, item)
        try:
            connection.send(answer)
        except (BrokenPipeError, ConnectionResetError):
            break
    sys.exit(0)


def _answer(work: Callable[[Any], Any], item: Any) -> tuple[bool, Any]:
    """Whether the work succeeded, and what it returned or raised."""
    try:
        return True, work(item)
    except Exception as error:
        error.add_note("raised in a prefetch process")
        return False, error


def _receive(connection: Connection, items: SimpleQueue[Any]) -> None:
    with suppress(EOFError, ConnectionResetError):
        while True:
            items.put(connection.recv())
    items.put(HUNG_UP)
