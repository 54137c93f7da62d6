"""Panoptic quality against a slow reading of its definition, cases with known answers, and what must always hold."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from razer.metrics.instances.panoptic_quality import ANY_CLASS, count_segments, merge_stuff, panoptic_quality


def labels(*runs: tuple[int, int]) -> np.ndarray:
    """(id, how many vertices) runs as one label per vertex."""
    return np.concatenate([np.full(count, number) for number, count in runs])


def slow(
    truth: np.ndarray, predicted: np.ndarray, true_classes: dict[int, str], classes: dict[int, str], smallest: int
) -> dict[str, tuple[float, float, float]]:
    """The definition by sets: every pair of one class, void vertices out of the union."""

    def sets(ids: np.ndarray, named: dict[int, str], name: str) -> list[set[int]]:
        return [set(np.flatnonzero(ids == i).tolist()) for i, c in named.items() if c == name and (ids == i).any()]

    void = {v for v, t in enumerate(truth.tolist()) if t not in true_classes}
    result = {}
    for name in sorted({*true_classes.values(), *classes.values()}):
        every_truth, every_prediction = sets(truth, true_classes, name), sets(predicted, classes, name)
        truths = [t for t in every_truth if len(t) >= smallest]
        predictions = [p for p in every_prediction if len(p) >= smallest]
        ious = [[len(t & p) / len(t | (p - void)) for p in predictions] for t in truths]
        matched = [v for row in ious for v in row if v > 0.5]
        small = set().union(*(t for t in every_truth if len(t) < smallest))
        wrong = 0
        for column, p in enumerate(predictions):
            if not any(row[column] > 0.5 for row in ious) and len(p & (void | small)) <= len(p) / 2:
                wrong += 1
        weight = len(matched) + wrong / 2 + (len(truths) - len(matched)) / 2
        if weight:
            mean = sum(matched) / len(matched) if matched else 0.0
            result[name] = (sum(matched) / weight, mean, len(matched) / weight)
    return result


@settings(max_examples=80, deadline=None)
@given(st.integers(0, 100_000), st.integers(1, 6))
def test_counts_are_those_of_the_definition(seed: int, smallest: int) -> None:
    rng = np.random.default_rng(seed)
    truth = np.repeat(rng.integers(0, 5, 12), rng.integers(1, 9, 12))
    predicted = np.where(rng.random(len(truth)) < 0.7, truth + rng.integers(0, 2), rng.integers(0, 6, len(truth)))
    true_classes = {i: str(rng.choice(["a", "b"])) for i in range(1, 4)}
    classes = {i: str(rng.choice(["a", "b"])) for i in range(1, 6)}
    counts = count_segments(truth, predicted, true_classes, classes, smallest)
    expected = slow(truth, predicted, true_classes, classes, smallest)
    result = panoptic_quality([counts])
    known = {name: n for name, n in result.per_class.items() if not math.isnan(n[0])}
    assert set(known) == set(expected)
    for name, numbers in expected.items():
        assert known[name] == pytest.approx(numbers, abs=1e-12)
    if expected:
        assert result.pq == pytest.approx(np.mean([n[0] for n in expected.values()]), abs=1e-12)


def test_known_answer() -> None:
    # IoU 80/100, one wrong of 50, one missed of 60: PQ = 0.8 / (1 + 1/2 + 1/2).
    truth, predicted = labels((1, 100), (2, 60), (3, 200)), labels((7, 80), (0, 80), (8, 50), (0, 150))
    result = panoptic_quality([count_segments(truth, predicted, {1: "x", 2: "x", 3: "y"}, {7: "x", 8: "x"})])
    assert result.per_class["x"] == pytest.approx((0.4, 0.8, 0.5))
    assert result.per_class["y"] == (0.0, 0.0, 0.0)
    assert result.pq == pytest.approx(0.2)


def test_quality_is_segmentation_times_recognition_in_each_class() -> None:
    rng = np.random.default_rng(1)
    counts = count_segments(np.repeat(np.arange(20), 10), np.repeat(np.arange(25), 8) + rng.integers(0, 2, 200))
    pq, sq, rq = panoptic_quality([counts]).per_class[ANY_CLASS]
    assert pq == pytest.approx(sq * rq)


def test_what_lies_on_void_neither_shrinks_the_overlap_nor_is_wrong() -> None:
    truth, predicted = labels((1, 100), (0, 100)), labels((5, 190), (0, 10))
    assert panoptic_quality([count_segments(truth, predicted)]).pq == 1.0
    # Half of it on void is not more than half: wrong.
    half = count_segments(labels((1, 100), (0, 10)), labels((5, 90), (6, 20)))[ANY_CLASS]
    assert (half.true_positives, half.false_positives) == (1, 1)
    more = count_segments(labels((1, 100), (0, 11)), labels((5, 90), (6, 21)))[ANY_CLASS]
    assert (more.true_positives, more.false_positives) == (1, 0)


def test_empty_sides_and_truth_against_itself() -> None:
    nothing, something = np.zeros(50, int), np.repeat([1, 2], 25)
    assert math.isnan(panoptic_quality([count_segments(nothing, something)]).pq)
    assert math.isnan(panoptic_quality([]).pq)
    assert panoptic_quality([count_segments(something, nothing)]).pq == 0.0
    assert panoptic_quality([count_segments(something, something)]).pq == 1.0


def test_scenes_are_added_up_before_the_division() -> None:
    good = count_segments(labels((1, 10)), labels((1, 10)))
    bad = count_segments(labels((1, 10), (2, 10), (3, 10)), labels((0, 30)))
    assert panoptic_quality([good, bad]).pq == pytest.approx(1 / (1 + 3 / 2))


def test_stuff_is_one_segment_whatever_instances_it_has() -> None:
    # Two walls, a vertex run of the class wall without an instance, and a chair.
    instances, classes = labels((1, 10), (2, 10), (0, 5), (3, 10)), labels((4, 25), (6, 10))
    segments, named = merge_stuff(instances, classes, {1: 4, 2: 4, 3: 6}, [4])
    assert len(set(segments[:25].tolist())) == 1
    assert named[int(segments[0])] == 4
    assert segments[25:].tolist() == [3] * 10
    assert named[3] == 6
    assert set(named) == {int(segments[0]), 3}
