from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
from fastapi.testclient import TestClient

from app.server.served import Served
from tests.support.browser import chromium
from tests.support.served_maps import client_of, saved_map, served_map


@pytest.fixture(scope="module")
def browser() -> Iterator[Any]:
    with chromium() as found:
        yield found


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    return saved_map(tmp_path / "run")


@pytest.fixture
def served(folder: Path) -> Served:
    return served_map(folder)


@pytest.fixture
def client(served: Served) -> Iterator[TestClient]:
    with client_of(served) as client:
        yield client
