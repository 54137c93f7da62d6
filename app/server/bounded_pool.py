"""Threads that work on requests: few at once, and not many waiting."""

from __future__ import annotations

import asyncio
import queue
import threading
from collections.abc import Callable
from concurrent.futures import Future
from typing import Any, TypeVar

from app.server.problems import Refusal

T = TypeVar("T")


class BoundedPool:
    """Runs functions in threads; refuses what would have to wait behind too many others. The threads are daemons: the
    program ends without waiting for what nobody waits for any more."""

    def __init__(self, threads: int, waiting: int) -> None:
        self._most = self._free = threads + waiting
        self._work: queue.SimpleQueue[tuple[Future[Any], Callable[[], Any]]] = queue.SimpleQueue()
        for number in range(threads):
            threading.Thread(target=self._serve, name=f"razer-serve-{number}", daemon=True).start()

    async def run(self, work: Callable[[], T]) -> T:
        """What `work` gives; raises Refusal 429 where too much is waiting."""
        if self._free == 0:
            raise Refusal(429, "too many requests at once: try again", headers={"retry-after": "1"})
        self._free -= 1
        loop, future = asyncio.get_running_loop(), Future[T]()

        def release(_: object) -> None:
            if not loop.is_closed():
                loop.call_soon_threadsafe(self._release)

        future.add_done_callback(release)
        self._work.put((future, work))
        return await asyncio.wrap_future(future)

    @property
    def is_idle(self) -> bool:
        """Whether no thread works, and none has anything to begin with."""
        return self._free == self._most

    def _serve(self) -> None:
        while True:
            future, work = self._work.get()
            if not future.set_running_or_notify_cancel():  # who asked is gone
                continue
            try:
                future.set_result(work())
            except BaseException as error:
                future.set_exception(error)

    def _release(self) -> None:
        self._free += 1
