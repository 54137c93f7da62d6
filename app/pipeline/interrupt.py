"""Graceful interruption: the first Ctrl-C asks for an early, complete end."""

from __future__ import annotations

import signal
import threading
from collections.abc import Iterable, Iterator
from types import FrameType, TracebackType
from typing import TypeVar

T = TypeVar("T")

INTERRUPTED = 130  # the exit code of a verb that Ctrl-C ended, as shells have it: 128 + SIGINT
FAILED = 1  # and of one whose helper processes ended before it did
TERMINATED = 143  # and that of one that was told to end: 128 + SIGTERM

_SIGNALS = (signal.SIGINT, signal.SIGTERM)


class StopRequest:
    """Within this context the first Ctrl-C, or SIGTERM, sets `requested` and `exit_code`; the second one interrupts as
    usual."""

    def __init__(self) -> None:
        self.requested = False
        self.exit_code = 0
        # Only the main thread may handle signals; elsewhere Ctrl-C is not ours to see.
        self._handles = threading.current_thread() is threading.main_thread()

    def __enter__(self) -> StopRequest:
        if self._handles:
            self._previous = {kind: signal.signal(kind, self._on_interrupt) for kind in _SIGNALS}
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        if self._handles:
            for number, handler in self._previous.items():
                signal.signal(number, handler)

    def _on_interrupt(self, signum: int, frame: FrameType | None) -> None:
        self.requested = True
        self.exit_code = TERMINATED if signum == signal.SIGTERM else INTERRUPTED
        for number, handler in self._previous.items():
            signal.signal(number, handler)


def until_interrupted(items: Iterable[T], stop: StopRequest) -> Iterator[T]:
    """The items that come before a stop is requested."""
    for item in items:
        if stop.requested:
            return
        yield item
