"""Benchmark of a served map: how long queries take when many ask at once, each with a connection of its own."""

from __future__ import annotations

import json
import re
import subprocess
import sys
import tempfile
from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor
from contextlib import contextmanager
from http.client import HTTPConnection
from pathlib import Path
from threading import Barrier
from time import perf_counter
from urllib.parse import urlsplit

import numpy as np

from app.console.streams import result_console
from razer.boxes.oriented_box import OrientedBox
from razer.map_object import MapObject
from razer.mesh.labelled_mesh import LabelledMesh
from razer.models.oracle.embedder import OracleEmbedder
from razer.panoptic_map import PanopticMap
from razer.vocabulary import vocabulary

INSTANCES, CLIENTS, ROUNDS = 500, 50, 10
_CORNERS = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0]], np.float32)


def measure_serving() -> dict[str, float]:
    """Milliseconds of queries by text, each another name, from 50 clients that all ask at the same time, ten times.

    The map of 500 instances is served by a process of its own, which has worked out its page and relations (its first
    seconds) by then. Returns the median, the 95th percentile and the queries a second.
    """
    names = vocabulary("lvis").names
    with tempfile.TemporaryDirectory() as folder:
        _many_instances(names).save(folder)
        (Path(folder) / "config.toml").write_text('[embedder]\nname = "oracle"\n', encoding="utf-8")
        with _served(Path(folder)) as address:
            _await_page(address)
            _ask(address, names[:1], Barrier(1))  # what the first one makes ready, all others find
            barrier = Barrier(CLIENTS)
            with ThreadPoolExecutor(CLIENTS) as pool:
                asked = [names[client::CLIENTS][:ROUNDS] for client in range(CLIENTS)]
                times_ms = np.array(list(pool.map(lambda texts: _ask(address, texts, barrier), asked)))
    return {
        "instances": INSTANCES,
        "clients": CLIENTS,
        "median_ms": round(float(np.median(times_ms)), 1),
        "p95_ms": round(float(np.quantile(times_ms, 0.95)), 1),
        "queries_per_s": round(1e3 * times_ms.size / float(times_ms.max(axis=0).sum()), 1),
    }


def print_serving(result: dict[str, float]) -> None:
    """Print the figures in one line."""
    result_console().print(
        f"{result['clients']:.0f} queries at once of a served map of {result['instances']:.0f} instances: median "
        f"{result['median_ms']:.0f} ms, p95 {result['p95_ms']:.0f} ms, {result['queries_per_s']:.0f} a second",
        soft_wrap=True,
    )


def _many_instances(names: tuple[str, ...]) -> PanopticMap:
    embedder = OracleEmbedder()
    vectors = embedder.embed_texts([names[number % len(names)] for number in range(INSTANCES)])
    places = np.stack(np.divmod(np.arange(INSTANCES), 25), axis=1).astype(np.float32)
    low = np.concatenate([places, np.zeros((INSTANCES, 1), np.float32)], axis=1)
    mesh = LabelledMesh(
        (low[:, None] + 0.5 * _CORNERS).reshape(-1, 3),
        np.full((3 * INSTANCES, 3), 128, np.uint8),
        np.repeat(np.arange(1, INSTANCES + 1, dtype=np.int32), 3),
        np.arange(3 * INSTANCES, dtype=np.int32).reshape(-1, 3),
    )
    objects = tuple(
        MapObject(
            id=row + 1,
            class_name=names[row % len(names)],
            score=0.9,
            box=OrientedBox(low[row].astype(np.float64), np.eye(3), np.full(3, 0.5)),
            n_voxels=3,
            n_vertices=3,
            observations=5,
            first_frame=0,
            last_frame=9,
            embeddings=vectors[row : row + 1],
            weights=np.ones(1),
        )
        for row in range(INSTANCES)
    )
    return PanopticMap(objects, mesh, up=np.array([0.0, 0.0, 1.0]))


@contextmanager
def _served(folder: Path) -> Iterator[str]:
    command = [sys.executable, "-m", "app", "serve", str(folder), "--port", "0"]
    with subprocess.Popen(command, stdout=subprocess.PIPE, text=True) as process:
        assert process.stdout is not None
        try:
            found = re.search(r"http://\S+", process.stdout.readline())
            assert found, "the server did not start"
            yield found[0]
        finally:
            process.terminate()


def _await_page(address: str) -> None:
    """Until the server has made what it makes when it starts."""
    connection = HTTPConnection(urlsplit(address).netloc, timeout=120)
    connection.request("GET", "/api/v1/page")
    connection.getresponse().read()
    connection.close()


def _ask(address: str, texts: tuple[str, ...], barrier: Barrier) -> list[float]:
    """Milliseconds of each question, all of which wait for those of the other clients."""
    connection = HTTPConnection(urlsplit(address).netloc, timeout=60)
    times_ms = []
    for text in texts:
        barrier.wait()
        started_s = perf_counter()
        connection.request("POST", "/api/v1/query", json.dumps({"text": text}), {"content-type": "application/json"})
        response = connection.getresponse()
        content = response.read()
        times_ms.append(1e3 * (perf_counter() - started_s))
        if response.status != 200:
            raise RuntimeError(f"the server answered {response.status}: {content[:200]!r}")
    connection.close()
    return times_ms
