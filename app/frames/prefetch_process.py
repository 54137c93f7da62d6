"""Prefetching in a process of its own, in order.

A thread would not do: perceiving a frame is many small array operations that hold the interpreter's lock, and two
threads take turns at it (on two cores a kitchen ran at 6 frames a second with a thread, at 8 with a process).
"""

from __future__ import annotations

import pickle
import signal
import sys
from collections import deque
from collections.abc import Callable, Generator, Iterable, Iterator
from contextlib import closing, suppress
from multiprocessing import get_context
from multiprocessing.connection import Connection
from queue import SimpleQueue
from threading import Thread
from time import perf_counter
from typing import Any, TypeVar

from app.console.plain_warnings import warn_in_one_line
from app.frames.helper_wait import HelperWait

S = TypeVar("S")
T = TypeVar("T")
HUNG_UP = object()
POLL_S = 0.2
NEVER_OVER = HelperWait()


class HelperEnded(RuntimeError):
    """A helper process ended before its work was done."""


class _Helper:
    """A process that works on what it is sent, and answers in order."""

    def __init__(self, work: Callable[[Any], Any]) -> None:
        context = get_context("spawn")
        self._ours, theirs = context.Pipe()
        self._process = context.Process(target=_serve, args=(theirs, pickle.dumps(work)), name="prefetch", daemon=True)
        self._process.start()
        theirs.close()

    def send(self, item: object) -> None:
        """Ask for an item; one that ended says so when it is to answer."""
        with suppress(BrokenPipeError, ConnectionResetError):
            self._ours.send(item)

    def answers_within(self, timeout_s: float) -> bool:
        """Whether an answer comes, or the news that none will."""
        return self._ours.poll(timeout_s)

    def answer(self) -> tuple[bool, Any]:
        """Whether the next item succeeded, and what came of it; raises HelperEnded."""
        try:
            succeeded, result = self._ours.recv()
        except (EOFError, ConnectionResetError):
            raise HelperEnded(self._how_it_ended()) from None
        return succeeded, result

    def _how_it_ended(self) -> str:
        self._process.join(1.0)
        code = self._process.exitcode
        return "killed, perhaps as memory ran out" if code == -signal.SIGKILL else f"exit code {code}"

    def close(self) -> None:
        """End it: by itself, once nothing more will be asked, unless it is busy with what nobody waits for."""
        self._ours.close()
        self._process.join(0.2)
        self._process.terminate()
        self._process.join(1.0)
        self._process.kill()
        self._process.join()


class _Line:
    """Items that a helper process works on, in order; another process takes its place where one ended."""

    def __init__(
        self, work: Callable[[Any], Any], does: str, waiting: HelperWait, replacement: Callable[[Any, str], Any] | None
    ) -> None:
        self._work, self._does, self._waiting, self._replacement = work, does, waiting, replacement
        self._helper = _Helper(work)
        self._pending: deque[Any] = deque()
        self._n_in_row = 0  # items that ended a process, one after the other

    def __len__(self) -> int:
        return len(self._pending)

    def ask(self, item: object) -> None:
        """Take in an item."""
        self._pending.append(item)
        self._helper.send(item)

    def take(self) -> Iterator[Any]:
        """What came of the first of the items; nothing where the wait is over."""
        if not self._wait():
            return
        try:
            succeeded, result = self._helper.answer()
        except HelperEnded as how:
            yield self._replaced(str(how))
            return
        self._pending.popleft()
        self._n_in_row = 0
        if not succeeded:
            raise result
        yield result

    def _wait(self) -> bool:
        started_s = perf_counter()
        self._waiting.begin()
        while not self._helper.answers_within(POLL_S):
            if self._waiting.is_over:
                return False
            self._waiting.go_on(perf_counter() - started_s, f"the process that {self._does}")
        return True

    def _replaced(self, how: str) -> object:
        """What stands for the first of the items, with which the process ended; a new one has the others."""
        self._n_in_row += 1
        if self._replacement is None or self._n_in_row > 1:
            raise HelperEnded(f"the process that {self._does} ended ({how})")
        item = self._pending.popleft()
        self._helper.close()
        self._helper = _Helper(self._work)
        for left in self._pending:
            self._helper.send(left)
        return self._replacement(item, f"the process that {self._does} ended with it ({how})")

    def close(self) -> None:
        """End the process."""
        self._helper.close()


def prefetch(
    work: Callable[[S], T],
    items: Iterable[S],
    depth: int = 2,
    *,
    does: str = "works ahead",
    waiting: HelperWait = NEVER_OVER,
    replacement: Callable[[S, str], T] | None = None,
) -> Generator[T]:
    """`work(item)` for each item, in order, at most `depth` of them asked for before they are needed.

    `work`, items and what is made of them travel by pickle. What `work` raises is raised here, at that item's turn.

    Args:
        work: what is done.
        items: to be worked on.
        depth: how many are asked for ahead.
        does: what the process does, for messages.
        waiting: ends the wait, and so all of it, and says what is waited for.
        replacement: stands for what an item would have come to in whose turn the process ended, which is told how; a
            new process goes on with the next. Without it, or where the next item ends that one too, HelperEnded.
    """
    with closing(_Line(work, does, waiting, replacement)) as line:
        for item in items:
            line.ask(item)
            if len(line) > depth:
                yield from line.take()
        while len(line) and not waiting.is_over:
            yield from line.take()


def _serve(connection: Connection, packed_work: bytes) -> None:
    """Answer items until the other side hangs up, also because its process was killed. What the work needs is loaded
    with the first item, so that no room for it is an answer like any other."""
    warn_in_one_line()
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # Ctrl-C goes to the whole group, and is the parent's to handle
    items: SimpleQueue[Any] = SimpleQueue()
    # Taken in at once: two sides that both send what fills the pipe would wait for each other.
    Thread(target=_receive, args=(connection, items), daemon=True).start()
    work: list[Callable[[Any], Any]] = []
    while (item := items.get()) is not HUNG_UP:
        answer = _answer(packed_work, work, item)
        try:
            connection.send(answer)
        except (BrokenPipeError, ConnectionResetError):
            break
    sys.exit(0)


def _answer(packed_work: bytes, work: list[Callable[[Any], Any]], item: Any) -> tuple[bool, Any]:
    """Whether the work succeeded, and what it returned or raised; `work` holds it once it is loaded."""
    try:
        if not work:
            work.append(pickle.loads(packed_work))
        return True, work[0](item)
    except Exception as error:
        error.add_note("raised in a prefetch process")
        return False, error


def _receive(connection: Connection, items: SimpleQueue[Any]) -> None:
    with suppress(EOFError, ConnectionResetError):
        while True:
            items.put(connection.recv())
    items.put(HUNG_UP)
