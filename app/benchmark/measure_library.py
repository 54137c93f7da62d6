"""Benchmark of a library: time, recall and size of searches in many instances, and time to add a map."""

from __future__ import annotations

import os
import tempfile
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from datetime import timedelta
from functools import partial
from pathlib import Path
from time import perf_counter, time_ns
from typing import Any, TypeVar

import numpy as np
import pyarrow as pa
from rich.table import Table

from app.ablation.exemplars import Exemplars
from app.benchmark.made_up_library import INSTANCES_OF_MAP, made_up_exemplars, made_up_map, noisy, rows_of_maps
from app.console.streams import progress_console, result_console
from app.library.known_texts import KnownTexts
from app.library.map_search import MapSearch, Wanted
from app.library.tables.instance_library import InstanceLibrary, InstanceTable
from app.library.tables.instance_rows import Entry, rows_of
from app.library.tables.model_identity import ModelIdentity
from razer.arrays import Float32Array
from razer.plugins import EmbedderSettings
from razer.query.ranking import NegativePrompts
from razer.query.text_queries import EVERY_NAME

_MAPS_AT_ONCE, _WARM_UP, _NEAREST = 100, 50, 10
_ADDITIONS = 5
_ROUNDING = 1e-4  # of cosines of vectors of 16 bits
Times = list[float]
T = TypeVar("T")


class _Texts:
    """The texts of exemplars, as an encoder knows any text: names that it has no vector of are not asked for."""

    def __init__(self, exemplars: Exemplars) -> None:
        self._rows = {name: row for row, name in enumerate(exemplars.names)}
        self._text = exemplars.text

    def embed_texts(self, texts: list[str]) -> Float32Array:
        """The vectors (N, D) of names."""
        return self._text[[self._rows[text] for text in texts]]


@dataclass(frozen=True)
class _World:
    """The library that is asked: its table, and what its instances were made of."""

    exemplars: Exemplars
    table: InstanceTable
    rng: np.random.Generator


def measure_library(n_instances: int, vectors: Path | None, n_queries: int) -> dict[str, Any]:
    """Make a library of so many instances in a temporary folder, compact it, and ask it.

    Raises BadInput for a file `vectors` that is no table of exemplars.
    """
    exemplars = made_up_exemplars() if vectors is None else Exemplars.read(vectors)
    with tempfile.TemporaryDirectory() as place:
        uri = str(Path(place) / "library")
        world, made_s = _timed(lambda: _made(exemplars, n_instances, uri))
        _, compacted_s = _timed(lambda: InstanceLibrary(uri).tidy(timedelta(0)))
        n_bytes = _n_bytes(Path(uri))
        dimension = exemplars.text.shape[1]
        return {
            "format": 1,
            "instances": n_instances,
            "maps": n_instances // INSTANCES_OF_MAP,
            "dimension": dimension,
            "load_average": round(os.getloadavg()[0], 1),
            "make_s": round(made_s, 1),
            "compact_s": round(compacted_s, 1),
            "bytes_per_instance": round(n_bytes / n_instances),
            "times_float16_vector": round(n_bytes / n_instances / (2 * dimension), 3),
            "add_s": [round(_added_s(world, number), 3) for number in range(_ADDITIONS)],
            "nearest": _nearest(world, n_queries),
            "answers": _answers(world, n_queries),
        }


def _made(exemplars: Exemplars, n_instances: int, uri: str) -> _World:
    model = ModelIdentity.of(EmbedderSettings(name="exemplars"), exemplars.text.shape[1])
    table, rng = InstanceLibrary.made(uri, model), np.random.default_rng(1)
    for start in range(0, n_instances // INSTANCES_OF_MAP, _MAPS_AT_ONCE):
        numbers = range(start, min(start + _MAPS_AT_ONCE, n_instances // INSTANCES_OF_MAP))
        table.table.append(pa.concat_tables(rows_of_maps(exemplars, model, numbers, rng)), start + 1)
        if start % (10 * _MAPS_AT_ONCE) == 0:
            progress_console().print(f"{start * INSTANCES_OF_MAP:,} of {n_instances:,} instances")
    return _World(exemplars, table, rng)


def _added_s(world: _World, number: int) -> float:
    """Seconds to add a map that is in memory."""
    exemplars, table = world.exemplars, world.table
    rows = world.rng.integers(len(exemplars.names), size=INSTANCES_OF_MAP)
    panoptic = made_up_map(exemplars, rows, world.rng)

    def add() -> None:
        entry = Entry(f"/added/{number}", "added", time_ns(), "{}")
        table.add(rows_of(panoptic, entry, table.model), entry.generation)

    return _timed(add)[1]


def _nearest(world: _World, n: int) -> dict[str, Any]:
    """For each kind of vector: milliseconds of a search for the ten nearest, and how many of these an exact search
    finds as near."""
    result, width = {}, world.table.width(_NEAREST)
    for kind, vectors in _queries(world, n + _WARM_UP):
        searches = [_timed(partial(world.table.nearest, v[None], _NEAREST, None, width)) for v in vectors][_WARM_UP:]
        exact = [world.table.table.nearest(v[None], ("run",), _NEAREST, exact=True) for v in vectors[_WARM_UP:]]
        recalls = [_recall(found, true) for (found, _), true in zip(searches, exact, strict=True)]
        times = _percentiles([1e3 * seconds for _, seconds in searches])
        result[kind] = {**times, "recall_at_10": round(float(np.mean(recalls)), 4)}
    return result


def _queries(world: _World, n: int) -> Iterator[tuple[str, Float32Array]]:
    rows = world.rng.integers(len(world.exemplars.names), size=n)
    yield "text", world.exemplars.text[rows]
    yield "picture", noisy(world.exemplars.image[rows], world.rng)
    yield "exemplar", world.exemplars.image[rows]


def _recall(found: pa.Table, exact: pa.Table) -> float:
    farthest = exact["_distance"].to_numpy().max()
    return float((found["_distance"].to_numpy() <= farthest + _ROUNDING).sum() / len(exact))


def _answers(world: _World, n: int) -> dict[str, Any]:
    """Milliseconds of whole answers, with scores, to texts whose vectors are known, and to vectors of pictures."""
    names = list(world.exemplars.names[::EVERY_NAME])
    negatives = NegativePrompts(names, world.exemplars.text[::EVERY_NAME])
    search = MapSearch(world.table, KnownTexts(_Texts(world.exemplars), negatives, ("{}",)))
    rows = world.rng.integers(len(world.exemplars.names), size=n + _WARM_UP)
    texts = [world.exemplars.names[row] for row in rows]
    pictures = noisy(world.exemplars.image[rows], world.rng)
    return {
        "text": _percentiles([_ms(partial(search.by_text, text, Wanted())) for text in texts][_WARM_UP:]),
        "picture": _percentiles([_ms(partial(search.by_vector, each, Wanted())) for each in pictures][_WARM_UP:]),
    }


def _percentiles(times_ms: Times) -> dict[str, float]:
    return {f"p{share}_ms": round(float(np.percentile(times_ms, share)), 1) for share in (50, 95)}


def _ms(work: Callable[[], object]) -> float:
    return 1e3 * _timed(work)[1]


def _timed(work: Callable[[], T]) -> tuple[T, float]:
    started_s = perf_counter()
    result = work()
    return result, perf_counter() - started_s


def _n_bytes(folder: Path) -> int:
    return sum(path.stat().st_size for path in folder.rglob("*") if path.is_file())


def print_library(result: dict[str, Any]) -> None:
    """Print a row for each kind of question."""
    table = Table("question", "p50, ms", "p95, ms", "recall@10")
    for part in ("nearest", "answers"):
        for kind, row in result[part].items():
            recall = f"{row['recall_at_10']:.3f}" if "recall_at_10" in row else ""
            table.add_row(f"{part}: {kind}", f"{row['p50_ms']:.1f}", f"{row['p95_ms']:.1f}", recall)
    console = result_console()
    console.print(table)
    console.print(
        f"{result['instances']:,} instances in {result['maps']:,} maps, {result['bytes_per_instance']:,} bytes each, "
        f"{result['times_float16_vector']} times their vector; a map is added in {max(result['add_s'])} s; made in "
        f"{result['make_s']} s, compacted in {result['compact_s']} s; load {result['load_average']}",
        soft_wrap=True,
    )
