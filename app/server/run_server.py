"""The server itself: a socket, connections within bounds of number and time, and a quick, clean end."""

from __future__ import annotations

import asyncio
import contextlib
import logging
import signal
import socket
import threading
from collections.abc import Callable, Iterator
from types import FrameType
from typing import Any

import uvicorn
from starlette.types import ASGIApp
from uvicorn.protocols.http.h11_impl import H11Protocol

from razer.errors import BadInput

MAX_CONNECTIONS = 512
HEADER_TIMEOUT_S = 10.0
MAX_HEADER_BYTES = 16 * 2**10
KEEP_ALIVE_S = 5
STOP_S = 1  # for answers under way; then they are cut off
_BUSY_BODY = (
    b'{"type":"about:blank","title":"Service Unavailable","status":503,"detail":"too many connections are open"}'
)
_BUSY = (
    b"HTTP/1.1 503 Service Unavailable\r\ncontent-type: application/problem+json\r\nretry-after: 5\r\n"
    b"connection: close\r\ncontent-length: %d\r\n\r\n%b" % (len(_BUSY_BODY), _BUSY_BODY)
)


class BoundedProtocol(H11Protocol):
    """HTTP/1.1 for clients that send their headers in time and are not too many."""

    def __init__(self, *args: Any, **kwargs: Any) -> None:
        super().__init__(*args, **kwargs)
        self._header_timer: asyncio.TimerHandle | None = None

    def connection_made(self, transport: asyncio.Transport) -> None:  # type: ignore[override]
        """Take a connection, unless there are too many."""
        super().connection_made(transport)
        if len(self.connections) > MAX_CONNECTIONS:
            transport.write(_BUSY)
            transport.close()
            return
        self._wait_for_headers()

    def data_received(self, data: bytes) -> None:
        """Take what a client sends; the time for headers runs until they are whole."""
        n_before = self.scope
        super().data_received(data)
        if self.scope is not n_before:
            self._stop_waiting()
        elif self._header_timer is None and (self.cycle is None or self.cycle.response_complete):
            self._wait_for_headers()

    def connection_lost(self, exc: Exception | None) -> None:
        """Forget the connection."""
        self._stop_waiting()
        super().connection_lost(exc)

    def _wait_for_headers(self) -> None:
        self._header_timer = self.loop.call_later(HEADER_TIMEOUT_S, self._give_up)

    def _stop_waiting(self) -> None:
        if self._header_timer is not None:
            self._header_timer.cancel()
            self._header_timer = None

    def _give_up(self) -> None:
        self._header_timer = None
        if not self.transport.is_closing():
            self.transport.abort()


class Server(uvicorn.Server):
    """A server that a signal ends quickly: streams first, then what is under way."""

    def __init__(
        self,
        app: ASGIApp,
        on_stop: Callable[[], None],
        signals: tuple[signal.Signals, ...] = (signal.SIGINT, signal.SIGTERM),
    ) -> None:
        """`on_stop` ends what would go on by itself; `signals` end the server."""
        super().__init__(
            uvicorn.Config(
                app,
                http=BoundedProtocol,
                ws="none",
                lifespan="on",
                log_level="error",
                access_log=False,
                proxy_headers=False,
                server_header=False,
                timeout_keep_alive=KEEP_ALIVE_S,
                timeout_graceful_shutdown=STOP_S,
                h11_max_incomplete_event_size=MAX_HEADER_BYTES,
            )
        )
        self._on_stop, self._signals = on_stop, signals
        logging.getLogger("uvicorn.error").addFilter(_is_fault)

    async def shutdown(self, sockets: list[socket.socket] | None = None) -> None:
        """End the streams, then everything."""
        self._on_stop()
        await super().shutdown(sockets)

    @contextlib.contextmanager
    def capture_signals(self) -> Iterator[None]:
        """Signals end the server, and nothing else."""
        if threading.current_thread() is not threading.main_thread():
            yield
            return
        before = {number: signal.signal(number, self._stop) for number in self._signals}
        try:
            yield
        finally:
            for number, handler in before.items():
                signal.signal(number, handler)

    def _stop(self, number: int, frame: FrameType | None) -> None:
        self.force_exit = self.should_exit
        self.should_exit = True


def _is_fault(record: logging.LogRecord) -> bool:
    """Whether a message is about the server: not about clients that are gone, slow, or cut off at its end."""
    error = record.exc_info[1] if record.exc_info else None
    return not isinstance(error, ConnectionError | asyncio.CancelledError) and "graceful shutdown" not in record.msg


def open_socket(host: str, port: int) -> socket.socket:
    """A socket that listens, on any free port for 0; raises BadInput where the place is taken or is none."""
    if not 0 <= port <= 65535:
        raise BadInput(f"--port {port}: give a number from 1 to 65535, or 0 for any free one")
    try:
        family, kind, protocol, _, address = socket.getaddrinfo(host, port, type=socket.SOCK_STREAM)[0]
        listener = socket.socket(family, kind, protocol)
    except OSError:
        raise BadInput(f"--host {host} is no address of this machine") from None
    try:
        listener.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
        listener.bind(address)
        listener.listen(256)
    except OSError as error:
        listener.close()
        raise BadInput(f"{host}:{port} cannot be listened on ({error.strerror}): choose another --port") from None
    return listener


def address_of(listener: socket.socket) -> str:
    """What a browser calls a socket."""
    host, port = listener.getsockname()[:2]
    shown = "localhost" if host in ("0.0.0.0", "::") else f"[{host}]" if ":" in host else host
    return f"http://{shown}:{port}/"
