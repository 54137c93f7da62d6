"""A server on this machine that speaks as much of the Hugging Face Hub's protocol as a download needs."""

from __future__ import annotations

import hashlib
import json
import re
from collections.abc import Iterator
from contextlib import contextmanager
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
from threading import Thread
from typing import Any

COMMIT = "0123456789abcdef0123456789abcdef01234567"
LARGE = 1000  # bytes from which a file is stored beside the repository, as the hub's large ones are


class Hub:
    """Repositories as {repo: {file: content}}; what is asked for is kept in `log` as (method, path, range).

    cut_at: bytes of a body after which the connection breaks, once. down: answers are 503. damaged: bodies have a
    wrong last byte. gated: repositories that want a login.
    """

    def __init__(self, repos: dict[str, dict[str, bytes]]) -> None:
        self.repos = repos
        self.log: list[tuple[str, str, str | None]] = []
        self.cut_at: int | None = None
        self.goes_down = self.down = self.damaged = False
        self.gated: set[str] = set()
        self.url = ""

    def gets(self) -> list[tuple[str, str | None]]:
        """(path, range) of each body that was sent."""
        return [(path, part) for method, path, part in self.log if method == "GET" and path.startswith("/cdn/")]


@contextmanager
def serving(hub: Hub) -> Iterator[Hub]:
    """The hub at `hub.url` until the context ends."""
    server = ThreadingHTTPServer(("127.0.0.1", 0), type("Handler", (_Handler,), {"hub": hub}))
    hub.url = f"http://127.0.0.1:{server.server_port}"
    thread = Thread(target=server.serve_forever, args=(0.02,), daemon=True)
    thread.start()
    try:
        yield hub
    finally:
        server.shutdown()
        server.server_close()
        thread.join()


class _Handler(BaseHTTPRequestHandler):
    protocol_version = "HTTP/1.1"
    hub: Hub

    def log_message(self, format: str, *args: Any) -> None:
        pass

    def do_HEAD(self) -> None:
        self.do_GET()

    def do_GET(self) -> None:
        path = self.path.split("?")[0]
        self.hub.log.append((self.command, path, self.headers.get("Range")))
        if self.hub.down:
            self._answer(503, b"busy")
        elif match := re.fullmatch(r"/(\w[\w.-]*/[\w.-]+)/resolve/([^/]+)/(.+)", path):
            self._resolve(*match.groups())
        elif match := re.fullmatch(r"/api/models/(\w[\w.-]*/[\w.-]+)/tree/([^/]+)", path):
            self._tree(match[1])
        elif match := re.fullmatch(r"/cdn/(\w+)", path):
            contents = [body for files in self.hub.repos.values() for body in files.values()]
            self._body(next(body for body in contents if hashlib.sha256(body).hexdigest() == match[1]))
        else:
            self._answer(404, b"")

    def _resolve(self, repo: str, revision: str, name: str) -> None:
        files = self.hub.repos.get(repo)
        if files is None:
            self._answer(401, b"", {"X-Error-Code": "RepoNotFound"})
        elif repo in self.hub.gated:
            self._answer(403, b"", {"X-Error-Code": "GatedRepo"})
        elif name not in files:
            self._answer(404, b"", {"X-Error-Code": "EntryNotFound", "X-Repo-Commit": COMMIT})
        else:
            self._send_file(files[name])

    def _send_file(self, body: bytes) -> None:
        headers = {"X-Repo-Commit": COMMIT}
        if len(body) < LARGE:
            self._body(body, {**headers, "ETag": f'"{git_id(body)}"'})
            return
        sha256 = hashlib.sha256(body).hexdigest()
        # Another name of this machine: the hub's large files lie on another host too.
        where = self.hub.url.replace("127.0.0.1", "localhost") + f"/cdn/{sha256}"
        linked = {"X-Linked-Etag": f'"{sha256}"', "X-Linked-Size": str(len(body)), "Location": where}
        self._answer(302, b"", {**headers, **linked})

    def _tree(self, repo: str) -> None:
        rows = [
            {"type": "file", "path": name, "size": len(body), "oid": git_id(body)}
            for name, body in self.hub.repos[repo].items()
        ]
        self._answer(200, json.dumps(rows).encode(), {"Content-Type": "application/json"})

    def _body(self, body: bytes, headers: dict[str, str] | None = None) -> None:
        status, headers, start = 200, dict(headers or {}), 0
        if match := re.fullmatch(r"bytes=(\d+)-", self.headers.get("Range") or ""):
            status, start = 206, int(match[1])
            headers["Content-Range"] = f"bytes {start}-{len(body) - 1}/{len(body)}"
        if self.hub.damaged:
            body = body[:-1] + bytes([body[-1] ^ 1])
        self._answer(status, body[start:], headers)

    def _answer(self, status: int, body: bytes, headers: dict[str, str] | None = None) -> None:
        self.send_response(status)
        for key, value in {**(headers or {}), "Content-Length": str(len(body))}.items():
            self.send_header(key, value)
        self.end_headers()
        if self.command == "HEAD":
            return
        cut, self.hub.cut_at = (self.hub.cut_at, None) if len(body) >= LARGE else (None, self.hub.cut_at)
        self.wfile.write(body[:cut])
        if cut is not None:
            self.hub.down = self.hub.goes_down
            self.close_connection = True


def git_id(body: bytes) -> str:
    """The checksum of a small file: git's."""
    return hashlib.sha1(b"blob %d\0" % len(body) + body).hexdigest()
