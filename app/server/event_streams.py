"""Streams of server-sent events: bounded in number, and each in what waits for a slow reader."""

from __future__ import annotations

import asyncio
import json
from collections.abc import AsyncIterator
from contextlib import suppress
from typing import Any

from starlette.responses import StreamingResponse
from starlette.types import Receive, Scope, Send

from app.server.problems import Refusal

MAX_STREAMS = 64
MAX_WAITING = 64  # events for one reader; of one that is slower the oldest are dropped
HEARTBEAT_S = 15.0
_HEARTBEAT = ": still here\n\n"


class EventStreams:
    """What happens is told to everyone who listens. For one event loop; `announce` may come from any thread."""

    def __init__(self, max_streams: int = MAX_STREAMS, heartbeat_s: float = HEARTBEAT_S) -> None:
        self._max_streams, self._heartbeat_s = max_streams, heartbeat_s
        self._queues: set[asyncio.Queue[str | None]] = set()
        self._loop: asyncio.AbstractEventLoop | None = None
        self._is_closed = False

    @property
    def n_open(self) -> int:
        """How many listen."""
        return len(self._queues)

    def start(self) -> None:
        """Take the running event loop for the one that readers live in."""
        self._loop = asyncio.get_running_loop()

    def announce(self, event: str, data: dict[str, Any]) -> None:
        """Tell everyone of an event."""
        if self._loop is not None and not self._loop.is_closed():
            text = f"event: {event}\ndata: {json.dumps(data)}\n\n"
            with suppress(RuntimeError):  # the loop ended meanwhile
                self._loop.call_soon_threadsafe(self._put, text)

    def _put(self, text: str | None) -> None:
        for queue in self._queues:
            if queue.full():
                queue.get_nowait()
            queue.put_nowait(text)

    def response(self) -> EventResponse:
        """A new stream; raises Refusal 503 where there are as many as may be."""
        if self._is_closed or len(self._queues) >= self._max_streams:
            raise Refusal(503, "too many event streams are open: try again later", headers={"retry-after": "30"})
        queue: asyncio.Queue[str | None] = asyncio.Queue(MAX_WAITING)
        self._queues.add(queue)
        return EventResponse(self, queue)

    async def read(self, queue: asyncio.Queue[str | None]) -> AsyncIterator[str]:
        """What one reader is told, until it leaves or all streams end."""
        yield _HEARTBEAT
        while not self._is_closed:
            try:
                text = await asyncio.wait_for(queue.get(), self._heartbeat_s)
            except TimeoutError:
                text = _HEARTBEAT
            if text is None:
                return
            yield text

    def leave(self, queue: asyncio.Queue[str | None]) -> None:
        """Forget a reader."""
        self._queues.discard(queue)

    def close(self) -> None:
        """End all streams."""
        self._is_closed = True
        self._put(None)


class EventResponse(StreamingResponse):
    """A stream of events to one reader, whose place is free again however it ends."""

    def __init__(self, streams: EventStreams, queue: asyncio.Queue[str | None]) -> None:
        super().__init__(streams.read(queue), media_type="text/event-stream")
        self._streams, self._queue = streams, queue

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Send until the reader leaves."""
        try:
            await super().__call__(scope, receive, send)
        finally:
            self._streams.leave(self._queue)
