"""Benchmark of a query: ranking the instances of a large map against an embedded text."""

from __future__ import annotations

from statistics import median
from time import perf_counter

import numpy as np

from razer.arrays import Float32Array
from razer.query.embedding_table import EmbeddingTable
from razer.query.ranking import NegativePrompts, TextRanking

_INSTANCES, _NAMES, _DIMENSION = 10_000, 1_203, 512
_REPEATS = 9


def measure_ranking() -> dict[str, float]:
    """Milliseconds for a query over 10,000 instances of one to three embeddings each, sorted, and once for each map to
    prepare them against 1,203 negative prompts."""
    rng = np.random.default_rng(0)
    banks = {i: (_units(rng, 1 + i % 3), np.full(1 + i % 3, 1 / (1 + i % 3))) for i in range(_INSTANCES)}
    table, negatives = EmbeddingTable.of(banks), NegativePrompts([""] * _NAMES, _units(rng, _NAMES))
    started_s = perf_counter()
    ranking = TextRanking(table, negatives)
    ready_ms = 1e3 * (perf_counter() - started_s)
    times_ms = []
    for _ in range(_REPEATS):
        query = _units(rng, 1)
        started_s = perf_counter()
        np.argsort(-ranking.scores(query)[:, 0], kind="stable")
        times_ms.append(1e3 * (perf_counter() - started_s))
    return {"instances": _INSTANCES, "query_ms": round(median(times_ms), 1), "ready_ms": round(ready_ms)}


def _units(rng: np.random.Generator, n: int) -> Float32Array:
    vectors = rng.standard_normal((n, _DIMENSION), dtype=np.float32)
    return vectors / np.linalg.norm(vectors, axis=1, keepdims=True)
