"""Graceful interruption: the first Ctrl-C asks for an early, complete end."""

from __future__ import annotations

import signal
import threading
from collections.abc import Iterable, Iterator
from types import FrameType, TracebackType
from typing import TypeVar

T = TypeVar("T")

INTERRUPTED = 130  # the exit code of a verb that Ctrl-C ended, as shells have it: 128 + SIGINT


class StopRequest:
    """Within this context the first Ctrl-C sets `requested`; the second one interrupts as usual."""

    def __init__(self) -> None:
        self.requested = False
        # Only the main thread may handle signals; elsewhere Ctrl-C is not ours to see.
        self._handles = threading.current_thread() is threading.main_thread()

    def __enter__(self) -> StopRequest:
        if self._handles:
            self._previous = signal.signal(signal.SIGINT, self._on_interrupt)
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        if self._handles:
            signal.signal(signal.SIGINT, self._previous)

    def _on_interrupt(self, signum: int, frame: FrameType | None) -> None:
        self.requested = True
        signal.signal(signal.SIGINT, signal.default_int_handler)


def until_interrupted(items: Iterable[T], stop: StopRequest) -> Iterator[T]:
    """The items that come before a stop is requested."""
    for item in items:
        if stop.requested:
            return
        yield item
