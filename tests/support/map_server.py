"""The least server that the served page can live on: one saved room, names that can be edited, events."""

from __future__ import annotations

import json
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
from typing import Any

from app.page.html import page_html
from app.page.packet import pack, unpack


class FakeMap:
    """What the server knows; `blocks` is the packet of the changes of a growing mesh."""

    def __init__(self, payload: bytes) -> None:
        self.header, self.sections = unpack(payload)
        self.done: list[tuple[int, str]] = []
        self.epoch, self.posted, self.asked = 0, [], []
        self.blocks = b""
        self.news = threading.Condition()
        self.events: list[tuple[str, dict[str, Any]]] = []

    def payload(self) -> bytes:
        return pack(self.header | {"epoch": self.epoch}, self.sections)

    def rename(self, instance: int, name: str) -> None:
        record = next(r for r in self.header["instances"] if r["id"] == instance)
        self.done.append((instance, record["name"]))
        record["name"] = name
        self.tell("edit", {"epoch": self.epoch, "kind": "rename", "author": None})

    def undo(self) -> None:
        instance, name = self.done.pop()
        self.rename(instance, name)
        self.done.pop()

    def tell(self, event: str, data: dict[str, Any]) -> None:
        self.epoch += event == "edit"
        with self.news:
            self.events.append((event, data))
            self.news.notify_all()


def _query(text: str) -> dict[str, Any]:
    if "sit" not in text:
        return {"found": False, "statement": f"“{text}” is not in this map.", "hits": []}
    hit = {
        "id": 3,
        "name": "chair",
        "probability": 0.8,
        "score": 0.8,
        "runner_up": {"name": "stool", "probability": 0.15},
    }
    return {"found": True, "statement": "One thing to sit on.", "hits": [hit]}


class MapServer(ThreadingHTTPServer):
    daemon_threads = True

    def __init__(self, known: FakeMap) -> None:
        super().__init__(("127.0.0.1", 0), Handler)
        self.known = known


class Handler(BaseHTTPRequestHandler):
    server: MapServer

    def log_message(self, *_: Any) -> None:
        pass

    def answer(self, content: bytes | dict[str, Any], kind: str = "application/json", status: int = 200) -> None:
        data = json.dumps(content).encode() if isinstance(content, dict) else content
        self.send_response(status)
        self.send_header("Content-Type", kind)
        self.send_header("Content-Length", str(len(data)))
        self.end_headers()
        self.wfile.write(data)

    def do_GET(self) -> None:
        path = self.path.removeprefix("/api/v1/").split("?")[0]
        if self.path == "/":
            self.answer(page_html("served").encode(), "text/html; charset=utf-8")
        elif path == "page":
            self.answer(self.server.known.payload(), "application/octet-stream")
        elif path == "mesh/changes":
            self.answer(self.server.known.blocks, "application/octet-stream")
        elif path == "edits":
            self.answer({"can_undo": bool(self.server.known.done), "can_redo": False, "edits": []})
        elif path == "events":
            self.stream()
        else:
            self.answer({"title": "Not found", "detail": path}, "application/problem+json", 404)

    def do_POST(self) -> None:
        body = json.loads(self.rfile.read(int(self.headers["Content-Length"])))
        if self.path.endswith("/query"):
            self.server.known.asked.append(body)
            self.answer(_query(body["text"]))
        elif body["epoch"] < self.server.known.epoch:
            self.answer({"title": "stale", "detail": "somebody renamed it"}, "application/problem+json", 409)
        else:
            self.server.known.posted.append(body)
            self.server.known.rename(body["instance"], body["name"])
            self.answer({"format": 1, "epoch": self.server.known.epoch, "edit": body}, status=201)

    def do_DELETE(self) -> None:
        self.server.known.undo()
        self.answer({"format": 1, "epoch": self.server.known.epoch, "edit": {}})

    def stream(self) -> None:
        self.send_response(200)
        self.send_header("Content-Type", "text/event-stream")
        self.end_headers()
        seen = len(self.server.known.events)
        try:
            while True:
                with self.server.known.news:
                    self.server.known.news.wait(timeout=0.5)
                    fresh, seen = self.server.known.events[seen:], len(self.server.known.events)
                for event, data in fresh:
                    self.wfile.write(f"event: {event}\ndata: {json.dumps(data)}\n\n".encode())
                self.wfile.write(b": here\n\n")
                self.wfile.flush()
        except OSError:
            return


@contextmanager
def serving(payload: bytes) -> Iterator[tuple[str, FakeMap]]:
    """The address of a server, and its map."""
    known = FakeMap(payload)
    server = MapServer(known)
    threading.Thread(target=server.serve_forever, daemon=True).start()
    yield f"http://127.0.0.1:{server.server_address[1]}/", known
    server.shutdown()
