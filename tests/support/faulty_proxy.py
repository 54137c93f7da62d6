"""An object store on loopback, and a proxy before it that throttles, fails and breaks connections."""

from __future__ import annotations

import http.client
import random
import socket
import threading
from collections import Counter
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
from typing import Any
from urllib.parse import urlsplit
from urllib.request import Request, urlopen

import boto3
from moto.server import ThreadedMotoServer

BUCKET = "maps"
KEYS = {"AWS_ACCESS_KEY_ID": "test", "AWS_SECRET_ACCESS_KEY": "test", "AWS_REGION": "us-east-1"}
FAULTS = ("slow_down", "internal_error", "broken_before", "broken_after")
_BODY = "<?xml version='1.0'?><Error><Code>{code}</Code><Message>try again</Message></Error>"


class FaultyProxy(ThreadingHTTPServer):
    """Passes requests on to a store; a share of them fails, by a seed: told so, before it, or after it took effect."""

    daemon_threads = True

    def __init__(self, target: str, share: float, seed: int = 0) -> None:
        super().__init__(("127.0.0.1", 0), _Handler)
        self.target, self.share, self.rng = urlsplit(target).netloc, share, random.Random(seed)
        self.lock, self.happened = threading.Lock(), Counter[str]()

    @property
    def url(self) -> str:
        return f"http://127.0.0.1:{self.server_port}"

    def next_fault(self) -> str:
        with self.lock:
            fault = self.rng.choice(FAULTS) if self.rng.random() < self.share else "none"
            self.happened[fault] += 1
            return fault

    def handle_error(self, request: Any, client_address: Any) -> None:
        """Connections that break are what it is for."""


class _Handler(BaseHTTPRequestHandler):
    protocol_version = "HTTP/1.1"
    server: FaultyProxy

    def log_message(self, format: str, *args: Any) -> None:
        """Nothing is told."""

    def _pass_on(self) -> None:
        fault = self.server.next_fault()
        body = self.rfile.read(int(self.headers.get("content-length") or 0))
        if fault == "broken_before":
            self._break()
        elif fault in ("slow_down", "internal_error"):
            code, name = (503, "SlowDown") if fault == "slow_down" else (500, "InternalError")
            self._answer(code, [("content-type", "application/xml")], _BODY.format(code=name).encode())
        else:
            status, headers, content = self._asked(body)
            self._break() if fault == "broken_after" else self._answer(status, headers, content)

    def _asked(self, body: bytes) -> tuple[int, list[tuple[str, str]], bytes]:
        connection = http.client.HTTPConnection(self.server.target, timeout=30)
        try:
            headers = {k: v for k, v in self.headers.items() if k.lower() != "connection"}
            connection.request(self.command, self.path, body, headers)
            response = connection.getresponse()
            return response.status, response.getheaders(), response.read()
        finally:
            connection.close()

    def _answer(self, status: int, headers: list[tuple[str, str]], content: bytes) -> None:
        self.send_response_only(status)
        length = None
        for name, value in headers:
            if name.lower() == "content-length":
                length = value
            elif name.lower() not in ("transfer-encoding", "connection"):
                self.send_header(name, value)
        self.send_header("content-length", str(length if self.command == "HEAD" and length else len(content)))
        self.end_headers()
        if self.command != "HEAD":
            self.wfile.write(content)

    def _break(self) -> None:
        self.close_connection = True
        with suppress(OSError):
            self.connection.shutdown(socket.SHUT_RDWR)


for _method in ("GET", "PUT", "POST", "DELETE", "HEAD"):
    setattr(_Handler, f"do_{_method}", _Handler._pass_on)


@contextmanager
def faulty_store(share: float = 0.0, seed: int = 0) -> Iterator[FaultyProxy]:
    """A store with an empty bucket behind a proxy."""
    store = ThreadedMotoServer("127.0.0.1", 0, verbose=False)
    store.start()
    host, port = store.get_host_and_port()
    proxy = FaultyProxy(f"http://{host}:{port}", share, seed)
    threading.Thread(target=proxy.serve_forever, daemon=True).start()
    try:
        urlopen(Request(f"http://{host}:{port}/moto-api/reset", method="POST")).close()  # one process has one store
        names = {"aws_access_key_id": "test", "aws_secret_access_key": "test", "region_name": "us-east-1"}
        boto3.client("s3", endpoint_url=f"http://{host}:{port}", **names).create_bucket(Bucket=BUCKET)
        yield proxy
    finally:
        proxy.shutdown()
        proxy.server_close()
        store.stop()
