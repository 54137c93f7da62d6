"""Work done ahead, in order, in a process of its own.

A thread would not do: perceiving a frame is many small array operations that hold the interpreter's lock, and two
threads take turns at it (on two cores a kitchen ran at 6 frames a second with a thread, at 8 with a process).
"""

from __future__ import annotations

import signal
import sys
from collections import deque
from collections.abc import Callable, Iterable, Iterator
from contextlib import closing
from multiprocessing import get_context
from multiprocessing.connection import Connection
from typing import Any, TypeVar

T = TypeVar("T")


def work_ahead(work: Callable[[int], T], indices: Iterable[int], ahead: int = 2) -> Iterator[T]:
    """`work(index)` for each index, in order, at most `ahead` of them asked for before they are needed.

    `work` and what it returns travel by pickle. What it raises is raised here, at that index's turn.
    """
    context = get_context("spawn")
    ours, theirs = context.Pipe()
    process = context.Process(target=_serve, args=(theirs, work), name="ahead", daemon=True)
    process.start()
    theirs.close()
    pending: deque[int] = deque()
    try:
        with closing(ours):
            for index in indices:
                ours.send(index)
                pending.append(index)
                if len(pending) > ahead:
                    yield _received(ours, pending.popleft())
            while pending:
                yield _received(ours, pending.popleft())
    finally:
        # It ends by itself once the pipe is closed; one busy with a frame nobody waits for need not finish it.
        process.join(0.2)
        process.terminate()
        process.join()


def _received(connection: Connection, index: int) -> Any:
    try:
        succeeded, result = connection.recv()
    except (EOFError, ConnectionResetError):
        raise RuntimeError(f"the process that looks at frames ended while it worked on frame {index}") from None
    if succeeded:
        return result
    raise result


def _serve(connection: Connection, work: Callable[[int], Any]) -> None:
    """Answer indices until the other side hangs up, also because its process was killed."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # Ctrl-C goes to the whole group, and is the parent's to handle
    try:
        while True:
            index = connection.recv()
            try:
                answer = (True, work(index))
            except Exception as error:
                error.add_note("raised in the process that looks ahead")
                answer = (False, error)
            connection.send(answer)
    except (EOFError, BrokenPipeError, ConnectionResetError):
        sys.exit(0)
