"""Threads that work on requests: few at once, and not many waiting."""

from __future__ import annotations

import asyncio
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from typing import TypeVar

from app.server.problems import Refusal

T = TypeVar("T")


class BoundedPool:
    """Runs functions in threads; refuses what would have to wait behind too many others."""

    def __init__(self, threads: int, waiting: int) -> None:
        self._pool = ThreadPoolExecutor(threads, thread_name_prefix="razer-serve")
        self._free = threads + waiting

    async def run(self, work: Callable[[], T]) -> T:
        """What `work` gives; raises Refusal 429 where too much is waiting."""
        if self._free == 0:
            raise Refusal(429, "too many requests at once: try again", headers={"retry-after": "1"})
        self._free -= 1
        loop, future = asyncio.get_running_loop(), self._pool.submit(work)

        def release(_: object) -> None:
            if not loop.is_closed():
                loop.call_soon_threadsafe(self._release)

        future.add_done_callback(release)
        return await asyncio.wrap_future(future)

    def _release(self) -> None:
        self._free += 1

    def close(self) -> None:
        """Wait for nobody any more."""
        self._pool.shutdown(wait=False, cancel_futures=True)
