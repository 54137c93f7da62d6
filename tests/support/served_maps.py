"""A small hand-made map behind the interface of `razer serve`, without a socket, and in a process of its own."""

from __future__ import annotations

import re
import subprocess
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from fastapi.testclient import TestClient
from httpx import Response

from app.served_map.edit_models import told
from app.served_map.shared_map import SharedMap
from app.server.access_rules import AccessRules
from app.server.create_app import guarded
from app.server.served import Served
from tests.support.edited_maps import saved

ADDRESS = "http://127.0.0.1:8700"
API = "/api/v1"
PROBLEM = "application/problem+json"
TOKEN = "a-token-that-is-long-enough"


def saved_map(folder: Path) -> Path:
    """The hand-made map in a folder, with the embedder that made it."""
    saved(folder)
    (folder / "config.toml").write_text('[embedder]\nname = "oracle"\n')
    return folder


def served_map(folder: Path) -> Served:
    """A map folder as `razer serve` shares it."""
    shared = SharedMap(folder)
    served = Served(shared)
    shared.on_change(lambda last, epoch: served.events.announce("edit", told(last, epoch)))
    return served


@contextmanager
def client_of(served: Served, rules: AccessRules | None = None, address: str = ADDRESS) -> Iterator[TestClient]:
    """A client of a map, behind the guard."""
    app = guarded(served, rules or AccessRules("127.0.0.1"))
    with TestClient(app, base_url=address, raise_server_exceptions=False) as client:
        yield client


def problem_of(response: Response) -> dict[str, Any]:
    """The problem that a response is; fails where it is none."""
    assert response.headers["content-type"] == PROBLEM, response.text
    content: dict[str, Any] = response.json()
    assert content.keys() == {"type", "title", "status", "detail"}
    assert content["status"] == response.status_code
    return content


@contextmanager
def server_process(*arguments: object) -> Iterator[tuple[subprocess.Popen[str], str]]:
    """`razer serve` in a process, with its address; killed in the end if it has not ended."""
    command = [sys.executable, "-m", "app", "serve", *map(str, arguments), "--port", "0"]
    process = subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
    try:
        assert process.stdout is not None
        line = process.stdout.readline()
        match = re.search(r"http://[^ ]+:\d+/", line)
        assert match, line
        yield process, match[0]
    finally:
        process.kill()
        process.communicate()
