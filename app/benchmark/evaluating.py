"""Benchmark of the evaluator: a scene of the size that ScanNet's are, by the rules of its benchmark."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from tempfile import TemporaryDirectory
from time import perf_counter, process_time

import numpy as np

from data_tools.predictions.mask_file import mask_text, read_mask
from razer.arrays import BoolArray, IndexArray
from razer.metrics.presets import PRESETS
from razer.metrics.protocol.evaluation import evaluate
from razer.metrics.scene_pair import PredictedScene, TruthScene
from razer.vocabulary import vocabulary

_VERTICES = 200_000
_PREDICTIONS = 300
_THINGS = 60
_REPEATS = 9


def measure_evaluation() -> dict[str, float]:
    """Seconds of processor time for 300 overlapping masks on 200,000 vertices with 60 things in them, and for reading a
    mask file of as many vertices: milliseconds, and as a multiple of looking at its bytes once."""
    truth, predicted = _scene()
    started_s = process_time()
    evaluate([("scene", truth, predicted)], PRESETS["scannet200"]).as_json()
    evaluated = {"vertices": _VERTICES, "predictions": _PREDICTIONS, "cpu_s": round(process_time() - started_s, 2)}
    return evaluated | _measure_reading()


def _measure_reading() -> dict[str, float]:
    content = mask_text(np.random.default_rng(0).random(_VERTICES) < 0.5)
    with TemporaryDirectory() as folder:
        path = Path(folder) / "mask.txt"
        path.write_bytes(content)
        read_s = _best_s(lambda: read_mask(path))
        looked_s = _best_s(lambda: np.count_nonzero(np.frombuffer(path.read_bytes(), np.uint8)))
    return {"read_mask_ms": round(1000 * read_s, 2), "read_to_looking": round(read_s / looked_s, 1)}


def _best_s(work: Callable[[], object]) -> float:
    """The shortest time of several."""
    times = []
    for _ in range(_REPEATS):
        started_s = perf_counter()
        work()
        times.append(perf_counter() - started_s)
    return min(times)


def _scene() -> tuple[TruthScene, PredictedScene]:
    rng = np.random.default_rng(0)
    names = dict(enumerate(vocabulary("scannet200").names, start=1))
    # Things are runs of vertices, as they are in a mesh, and every sixth vertex belongs to none.
    instances = (np.arange(_VERTICES) * _THINGS // _VERTICES + 1) * (rng.random(_VERTICES) > 1 / 6)
    thing_classes = np.concatenate([[0], rng.integers(1, len(names) + 1, _THINGS)])
    truth = TruthScene(rng.random((_VERTICES, 3)) * 5, instances, thing_classes[instances], names)
    chosen = rng.integers(1, _THINGS + 1, _PREDICTIONS)
    predicted = PredictedScene(
        masks={i: _most_of(instances == thing, rng) for i, thing in enumerate(chosen, start=1)},
        scores=dict(enumerate(rng.random(_PREDICTIONS).tolist(), start=1)),
        class_names={i: names[int(thing_classes[thing])] for i, thing in enumerate(chosen, start=1)},
    )
    return truth, predicted


def _most_of(mask: BoolArray, rng: np.random.Generator) -> IndexArray:
    return np.flatnonzero(mask & (rng.random(len(mask)) < 0.8))
