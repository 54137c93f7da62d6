"""The evaluator's class-aware AP of overlapping masks against the benchmark's rules, and what it costs."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from razer.metrics.presets import PRESETS
from razer.metrics.protocol.evaluation import evaluate
from razer.metrics.scene_pair import PredictedScene, TruthScene
from razer.vocabulary import vocabulary
from tests.support.benchmark_rules import BenchmarkScene, averages, benchmark

LIST = vocabulary("scannet200")
NAMES = {category.id: category.name for category in LIST.categories}
LABELS = [category.id for category in LIST.categories if category.name not in ("wall", "floor")]


def pair(scene: BenchmarkScene) -> tuple[TruthScene, PredictedScene]:
    ids, predictions = scene
    classes = ids // 1000
    truth = TruthScene(np.zeros((len(ids), 3)), np.where(classes > 0, ids, 0), classes, NAMES)
    numbered = list(enumerate(predictions, start=1))
    return truth, PredictedScene(
        masks={number: np.flatnonzero(mask) for number, (mask, _, _) in numbered},
        scores={number: score for number, (_, _, score) in numbered},
        class_names={number: NAMES[label] for number, (_, label, _) in numbered if label in NAMES},
    )


def random_scene(rng: np.random.Generator) -> BenchmarkScene:
    """Truths of few classes, some small, some void, some walls; predictions that overlap, repeat and tie."""
    pool = rng.choice([2, 4, 7, 1, 3], 3, replace=False).tolist()
    sizes = rng.choice([60, 99, 100, 101, 180, 300], 6)
    ids = np.concatenate([np.full(s, rng.choice(pool) * 1000 + i + 1) for i, s in enumerate(sizes)] + [np.zeros(150)])
    ids = ids.astype(np.int64)
    predictions = []
    for _ in range(rng.integers(0, 12)):
        number = rng.choice(ids)
        mask = (ids == number) & (rng.random(len(ids)) < rng.choice([0.5, 0.7, 0.9, 1.0]))
        mask |= rng.random(len(ids)) < rng.choice([0.0, 0.05, 0.3])
        label = int(number // 1000) if rng.random() < 0.8 else int(rng.choice([*pool, 999]))
        predictions.append((mask, label, float(rng.choice([0.2, 0.5, 0.9]))))
    return ids, predictions


@settings(max_examples=40, deadline=None)
@given(st.integers(0, 100_000), st.integers(1, 3))
def test_class_aware_ap_is_the_benchmarks(seed: int, n_scenes: int) -> None:
    rng = np.random.default_rng(seed)
    scenes = [random_scene(rng) for _ in range(n_scenes)]
    labels = [2, 4, 7]
    preset = PRESETS["scannet200"].model_copy(update={"instance_classes": tuple(NAMES[i] for i in labels)})
    result = evaluate([(str(i), *pair(scene)) for i, scene in enumerate(scenes)], preset).class_aware
    expected = benchmark(scenes, labels)
    if not any(label in labels for _, predictions in scenes for _, label, _ in predictions):
        return
    assert result is not None
    for label, aps in expected.items():
        own = result["per_class"].get(NAMES[label], {"ap": math.nan, "ap50": math.nan, "ap25": math.nan})
        wanted = [np.mean(aps[:9]), aps[0], aps[9]]
        assert [own["ap"], own["ap50"], own["ap25"]] == pytest.approx(wanted, abs=1e-12, nan_ok=True)
    if not np.isnan(list(expected.values())).all():
        assert (result["ap"], result["ap50"], result["ap25"]) == pytest.approx(averages(expected), abs=1e-12)


def test_all_198_classes_are_looked_at_and_split_by_frequency() -> None:
    ids = np.repeat(np.array([label * 1000 + 1 for label in NAMES]), 100)
    truth, predicted = pair((ids, [(ids == label * 1000 + 1, label, 1.0) for label in LABELS[::2]]))
    result = evaluate([("all", truth, predicted)], PRESETS["scannet200"]).class_aware
    assert result is not None
    assert len(result["per_class"]) == 198
    groups = [category.group for category in LIST.categories if category.id in LABELS]
    assert {group: groups.count(group) for group in result["splits"]} == {"head": 64, "common": 68, "tail": 66}
    assert result["ap"] == pytest.approx(0.5)
    for group in result["splits"]:
        share = [label in LABELS[::2] for label, name in zip(LABELS, groups, strict=True) if name == group]
        assert result["splits"][group]["ap50"] == pytest.approx(np.mean(share))


def test_one_vertex_may_be_right_twice() -> None:
    # A table, and a cup on it that the table's mask covers too: both are right, which labels per vertex cannot say.
    ids = np.repeat([4001, 2002], [1000, 120])
    table, cup = np.ones(1120, bool), ids == 2002
    truth, predicted = pair((ids, [(table, 4, 1.0), (cup, 2, 1.0)]))
    result = evaluate([("one", truth, predicted)], PRESETS["scannet200"])
    assert result.class_aware is not None
    assert result.class_aware["ap50"] == 1.0
    assert result.missed == 0


def test_score_rules() -> None:
    # A wrong prediction before the right one, by its own score; of 150 vertices, so that size puts it last.
    ids = np.repeat([2001, 4002], [300, 150])
    scene = (ids, [(ids == 2001, 2, 0.3), (ids == 4002, 2, 0.9)])
    truth, predicted = pair(scene)

    def ap50(**rules: object) -> float:
        preset = PRESETS["scannet200"].model_copy(update={"instance_classes": ("chair", "table"), **rules})
        result = evaluate([("a", truth, predicted)], preset).class_aware
        assert result is not None
        return result["per_class"]["chair"]["ap50"]

    # Points (1/2, 1), (0, 0) and (1, 0): 1/4 + 0; tied (1/2, 1), (1, 0); right first (1/2, 1), (1, 1), (1, 0).
    assert ap50() == pytest.approx(0.25)
    assert ap50(score="one") == pytest.approx(0.75)
    assert ap50(score="size_share") == pytest.approx(1.0)
    assert ap50(optimistic=True) == pytest.approx(1.0)


def test_a_threshold_is_exceeded_or_reached() -> None:
    ids = np.repeat([2001, 0], [200, 100])
    mask = np.arange(300) < 100  # half of the truth exactly
    truth, predicted = pair((ids, [(mask, 2, 1.0)]))
    strict = evaluate([("a", truth, predicted)], PRESETS["scannet200"])
    reached = evaluate([("a", truth, predicted)], PRESETS["scannet200"].model_copy(update={"strict": False}))
    assert strict.class_agnostic is not None
    assert reached.class_agnostic is not None
    assert strict.class_agnostic["ap50"] == 0.0
    assert reached.class_agnostic["ap50"] == 1.0
