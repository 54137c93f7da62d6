"""An object store on loopback with the interface of S3, behind a proxy that throttles, fails and breaks connections."""

from __future__ import annotations

import random
from collections import Counter
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from dataclasses import dataclass, field
from http.client import HTTPConnection
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
from socket import SHUT_RDWR
from threading import Lock, Thread
from urllib.parse import urlsplit

import pytest
from moto.server import ThreadedMotoServer

KEY_ID, SECRET, BUCKET = "AKIATESTTESTTESTTEST", "wJalrXUtnFEMI-no-real-secret", "lab"
_SLOW_DOWN = b"<Error><Code>SlowDown</Code><Message>Please reduce your request rate.</Message></Error>"
_INTERNAL = b"<Error><Code>InternalError</Code><Message>We encountered an internal error.</Message></Error>"
_HOP = {"connection", "transfer-encoding", "content-length", "keep-alive", "date", "server"}


@dataclass
class Faults:
    """share: of requests that fail, by kind; met: how many did. seed: of which ones."""

    share: dict[str, float] = field(default_factory=dict)
    met: Counter[str] = field(default_factory=Counter)
    seed: int = 5

    def __post_init__(self) -> None:
        self._random, self._lock = random.Random(self.seed), Lock()

    def next(self) -> str:
        """What goes wrong with the next request, "" for nothing."""
        with self._lock:
            drawn = self._random.random()
            for kind, share in self.share.items():
                if drawn < share:
                    self.met[kind] += 1
                    return kind
                drawn -= share
        return ""


@dataclass(frozen=True)
class FaultyStore:
    """endpoint: with faults. direct: without. faults: which."""

    endpoint: str
    direct: str
    faults: Faults


@contextmanager
def faulty_store(monkeypatch: pytest.MonkeyPatch, seed: int = 5, **share: float) -> Iterator[FaultyStore]:
    """A store with an empty bucket; the environment of this process, and of those below it, leads to the proxy. share:
    of requests that are throttled, failed (before they took effect), refused, unanswered (after it), or cut."""
    server = ThreadedMotoServer(ip_address="127.0.0.1", port=0)
    server.start()
    host, port = server.get_host_and_port()
    faults = Faults(share, seed=seed)
    proxy = ThreadingHTTPServer(
        ("127.0.0.1", 0), type("Proxy", (_Proxy,), {"store": f"{host}:{port}", "faults": faults})
    )
    Thread(target=proxy.serve_forever, daemon=True).start()
    endpoint = f"http://127.0.0.1:{proxy.server_address[1]}"
    values = {
        "ACCESS_KEY_ID": KEY_ID,
        "SECRET_ACCESS_KEY": SECRET,
        "DEFAULT_REGION": "us-east-1",
        "ENDPOINT_URL": endpoint,
        "ALLOW_HTTP": "true",  # for LanceDB
    }
    for name, value in values.items():
        monkeypatch.setenv(f"AWS_{name}", value)
    try:
        _forward(f"{host}:{port}", "POST", "/moto-api/reset", {}, b"")  # all stores of one process are one
        _forward(f"{host}:{port}", "PUT", f"/{BUCKET}", {}, b"")
        yield FaultyStore(endpoint, f"http://{host}:{port}", faults)
    finally:
        proxy.shutdown()
        proxy.server_close()
        server.stop()


def _forward(store: str, method: str, path: str, headers: dict[str, str], body: bytes) -> tuple[int, list, bytes]:
    connection = HTTPConnection(urlsplit(f"http://{store}").netloc, timeout=60)
    try:
        connection.request(method, path, body, headers)
        answer = connection.getresponse()
        return answer.status, answer.getheaders(), answer.read()
    finally:
        connection.close()


class _Proxy(BaseHTTPRequestHandler):
    store: str
    faults: Faults
    protocol_version = "HTTP/1.1"

    def do_any(self) -> None:
        body = self._body()
        fault = self.faults.next()
        if fault in ("throttled", "failed"):
            self._answer(*((503, _SLOW_DOWN) if fault == "throttled" else (500, _INTERNAL)))
        elif fault == "refused":
            self._break()
        elif fault == "unanswered":
            _forward(self.store, self.command, self.path, dict(self.headers), body)
            self._break()
        else:
            status, headers, content = _forward(self.store, self.command, self.path, dict(self.headers), body)
            self._answer(status, content, headers, cut=fault == "cut")

    do_GET = do_PUT = do_POST = do_DELETE = do_HEAD = do_any  # noqa: N815

    def _body(self) -> bytes:
        if self.headers.get("Expect", "").lower() == "100-continue":
            self.send_response_only(100)
            self.end_headers()
        if "chunked" in self.headers.get("Transfer-Encoding", ""):
            return self._chunks()
        return self.rfile.read(int(self.headers.get("Content-Length") or 0))

    def _chunks(self) -> bytes:
        parts = []
        while size := int(self.rfile.readline().split(b";")[0], 16):
            parts.append(self.rfile.read(size))
            self.rfile.readline()
        self.rfile.readline()
        del self.headers["Transfer-Encoding"]
        self.headers["Content-Length"] = str(sum(map(len, parts)))
        return b"".join(parts)

    def _answer(self, status: int, content: bytes, headers: list = (), cut: bool = False) -> None:
        self.send_response_only(status)
        lengths = [value for name, value in headers if name.lower() == "content-length"]
        for name, value in headers:
            if name.lower() not in _HOP:
                self.send_header(name, value)
        length = lengths[0] if self.command == "HEAD" and lengths else str(len(content))
        self.send_header("Content-Length", length)
        self.end_headers()
        if self.command != "HEAD":
            self.wfile.write(content[: len(content) // 2] if cut else content)
        if cut:
            self.close_connection = True

    def _break(self) -> None:
        self.close_connection = True
        with suppress(OSError):
            self.connection.shutdown(SHUT_RDWR)

    def log_message(self, format: str, *args: object) -> None:
        pass
