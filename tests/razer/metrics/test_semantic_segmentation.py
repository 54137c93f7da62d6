"""Semantic metrics and the majority of five against literal readings of protocol C, and cases with known answers."""

from __future__ import annotations

import math
from collections import Counter

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from razer.metrics.presets import PRESETS
from razer.metrics.protocol.evaluation import evaluate
from razer.metrics.scene_pair import PredictedScene, TruthScene
from razer.metrics.semantic_segmentation import confusion, kept_classes, semantic_metrics
from razer.metrics.surface.nearest_vertices import nearest_vertices

NAMES = {1: "wall", 2: "chair", 3: "table", 4: "wall-cabinet", 5: "other"}


def hovsg(truth: list[int], predicted: list[int], ignored: list[int]) -> tuple[float, float, float, float]:
    """mIoU, F-mIoU, mAcc and pixel accuracy, vertex by vertex."""
    classes = [c for c in sorted(set(truth)) if c not in ignored]
    if not classes:
        return (math.nan,) * 4
    n = {c: sum(t == p == c for t, p in zip(truth, predicted, strict=True)) for c in classes}
    t, p = Counter(truth), Counter(predicted)
    iou = {c: n[c] / (t[c] + p[c] - n[c]) for c in classes}
    left = len(truth) - sum(t[c] for c in t if c in ignored)
    return (
        sum(iou.values()) / len(classes),
        sum(t[c] * iou[c] for c in classes) / left,
        sum(n[c] / t[c] for c in classes) / len(classes),
        sum(n.values()) / sum(t[c] for c in classes),
    )


def conceptgraphs(truth: list[int], predicted: list[int], ignored: list[int]) -> tuple[float, float]:
    """mIoU and F-mIoU of the vertices whose true class is kept."""
    both = [(t, p) for t, p in zip(truth, predicted, strict=True) if t not in ignored]
    if not both:
        return (math.nan,) * 2
    return hovsg([t for t, _ in both], [p for _, p in both], [])[:2]


def majority(source: np.ndarray, labels: np.ndarray, points: np.ndarray, k: int, unlabelled: bool) -> list[int]:
    """The most frequent label of the k nearest, with or without the unlabelled ones, one point after the other: nearer
    first, then (for one neighbour) that of the very place and number of the point, then the lower number."""
    majority = []
    for own, point in enumerate(points):
        square = [float((x - point[0]) ** 2 + (y - point[1]) ** 2 + (z - point[2]) ** 2) for x, y, z in source]
        voters = [i for i in range(len(source)) if unlabelled or labels[i] > 0]
        nearest = sorted(voters, key=lambda i: (square[i], k == 1 and square[i] == 0 and i != own, i))[:k]
        counted = Counter(int(labels[i]) for i in nearest)
        majority.append(min(counted, key=lambda label: (-counted[label], label)))
    return majority


@settings(max_examples=40, deadline=None)
@given(st.integers(0, 100_000), st.booleans())
def test_numbers_are_those_of_the_formulas(seed: int, on_grid: bool) -> None:
    rng = np.random.default_rng(seed)
    # On a grid most distances tie, the k-th as well.
    points = rng.integers(0, 4, (80, 3)) * 0.25 if on_grid else rng.random((80, 3))
    surface = rng.integers(0, 4, (60, 3)) * 0.25 if on_grid else rng.random((60, 3))
    truth, predicted = rng.integers(0, 6, 80), rng.integers(0, 6, 60)
    pair = (
        "a",
        TruthScene(points, np.zeros(80, int), truth, NAMES),
        PredictedScene(surface, classes=predicted, vertex_class_names=NAMES),
    )
    five = majority(surface, predicted, points, 5, unlabelled=True)
    result = evaluate([pair], PRESETS["hovsg"]).semantic
    expected = hovsg(truth.tolist(), five, [0, 1, 4])
    assert result is not None
    keys = ("miou", "fmiou", "macc", "pixel_accuracy")
    assert [result[key] for key in keys] == pytest.approx(expected, abs=1e-12, nan_ok=True)
    nearest = majority(surface, predicted, points, 1, unlabelled=False)
    result = evaluate([pair], PRESETS["conceptgraphs"]).semantic
    assert result is not None
    expected_pair = conceptgraphs(truth.tolist(), nearest, [0, 1, 5])
    assert (result["miou"], result["fmiou"]) == pytest.approx(expected_pair, abs=1e-12, nan_ok=True)
    less = conceptgraphs(truth.tolist(), nearest, [0, 5])
    assert result["lists"]["without 1"]["miou"] == pytest.approx(less[0], abs=1e-12)


def test_neighbours_of_a_large_grid_are_ordered_by_distance_then_number() -> None:
    grid = np.stack(np.meshgrid(*[np.arange(5)] * 3, indexing="ij"), axis=-1).reshape(-1, 3).astype(float)
    middles = grid + 0.5  # eight equally near ones, more than are asked for at first
    square = ((middles[:, None] - grid) ** 2).sum(axis=2)
    expected = np.argsort(square, axis=1, kind="stable")[:, :3]
    assert (nearest_vertices(grid, middles, 3).index == expected).all()


def test_fewer_vertices_than_neighbours() -> None:
    source, point = np.array([[0.0, 0, 0], [1, 0, 0]]), np.array([[0.2, 0, 0]])
    assert nearest_vertices(source, point, 5).index.tolist() == [[0, 1, 2, 2, 2]]
    assert nearest_vertices(source, point, 5).labels(np.array([7, 3])).tolist() == [3]
    assert nearest_vertices(source, point, 5, 0.5).labels(np.array([7, 3])).tolist() == [7]
    assert nearest_vertices(source[:0], point, 5).labels(np.zeros(0, int)).tolist() == [0]


def test_labels_transferred_to_the_same_surface_stay_though_vertices_coincide() -> None:
    twins = np.zeros((4, 3))
    assert nearest_vertices(twins, twins).labels(np.array([4, 3, 2, 1])).tolist() == [4, 3, 2, 1]


def test_known_answer() -> None:
    truth = np.array([2] * 6 + [3] * 4 + [1] * 5 + [0] * 5)
    predicted = np.array([2] * 4 + [3] * 2 + [3] * 4 + [2] * 2 + [1] * 3 + [3] * 4 + [0])
    counted = confusion(truth, predicted, NAMES)
    assert counted["wall", "chair"] == 2
    assert counted["", "table"] == 4
    numbers = semantic_metrics(counted, lambda name: name != "wall")
    assert numbers.per_class["chair"].iou == pytest.approx(4 / (6 + 6 - 4))
    assert numbers.per_class["table"].iou == pytest.approx(4 / (4 + 10 - 4))
    assert numbers.miou == pytest.approx(0.45)
    assert numbers.pixel_accuracy == pytest.approx(0.8)
    # Without what lies on walls and on the unlabelled, p is 4 and 6.
    fewer = semantic_metrics(counted, lambda name: name != "wall", count_ignored_points=False)
    assert fewer.miou == pytest.approx((4 / 6 + 4 / 6) / 2)


def test_a_word_leaves_out_every_class_that_has_it_and_a_name_only_its_own() -> None:
    hovsg_kept, conceptgraphs_kept = kept_classes(PRESETS["hovsg"]), kept_classes(PRESETS["conceptgraphs"])
    assert not hovsg_kept("wall-cabinet")
    assert conceptgraphs_kept("wall-cabinet")
    assert not conceptgraphs_kept("other")
    assert not kept_classes(PRESETS["ovo"])("other")
    assert kept_classes(PRESETS["ovo"])("wall")


def test_no_class_that_counts_gives_nothing() -> None:
    assert math.isnan(semantic_metrics(confusion(np.ones(3, int), np.ones(3, int), NAMES), lambda _: False).miou)
    assert semantic_metrics(Counter(), lambda _: True).per_class == {}


def test_pooled_and_mean_over_scenes_differ() -> None:
    def pair(wrong: int, size: int) -> tuple[str, TruthScene, PredictedScene]:
        classes = np.full(size, 2)
        predicted = np.where(np.arange(size) < wrong, 3, 2)
        truth = TruthScene(np.random.default_rng(0).random((size, 3)), np.zeros(size, int), classes, NAMES)
        return str(wrong), truth, PredictedScene(classes=predicted, vertex_class_names=NAMES)

    preset = PRESETS["conceptgraphs"]
    pooled = evaluate([pair(5, 10), pair(0, 90)], preset).semantic
    mean = evaluate([pair(5, 10), pair(0, 90)], preset.model_copy(update={"semantics_over_scenes": "mean"})).semantic
    assert pooled is not None
    assert mean is not None
    assert pooled["miou"] == pytest.approx(95 / 100)
    assert mean["miou"] == pytest.approx(0.75)
