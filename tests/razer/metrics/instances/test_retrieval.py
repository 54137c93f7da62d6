"""Top-1 retrieval of the truth's masks and of predicted ones: counts by hand and by a slow reading of protocol D."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from razer.metrics.instances.matching import count_overlaps
from razer.metrics.instances.retrieval import RetrievalCounts, given_mask_retrieval, predicted_mask_retrieval
from razer.metrics.presets import PRESETS
from razer.metrics.protocol.evaluation import evaluate
from razer.metrics.scene_pair import PredictedScene, TruthScene
from razer.vocabulary import vocabulary


@settings(max_examples=60, deadline=None)
@given(st.integers(0, 100_000), st.booleans())
def test_predicted_masks_are_those_of_the_largest_overlap(seed: int, missed_is_wrong: bool) -> None:
    rng = np.random.default_rng(seed)
    truth = np.repeat(rng.integers(0, 5, 10), rng.integers(1, 6, 10))
    predicted = np.where(rng.random(len(truth)) < 0.6, truth, rng.integers(0, 5, len(truth)))
    true_classes = {i: str(rng.choice(["a", "b"])) for i in (1, 2, 3)}
    classes = {i: str(rng.choice(["a", "b"])) for i in (1, 2, 4)}
    asked, right = {"a": 0, "b": 0}, {"a": 0, "b": 0}
    for number, name in true_classes.items():
        own = set(np.flatnonzero(truth == number).tolist())
        if not own:
            continue
        others = {p: set(np.flatnonzero(predicted == p).tolist()) for p in sorted(set(predicted.tolist())) if p > 0}
        ious = {p: len(own & s) / len(own | s) for p, s in others.items()}
        best = max(ious, key=lambda p: (ious[p], -p), default=0)
        is_matched = bool(ious) and ious[best] > 0.25
        asked[name] += is_matched or missed_is_wrong
        right[name] += is_matched and classes.get(best) == name
    counts = predicted_mask_retrieval(count_overlaps(truth, predicted), true_classes, classes, 0.25, missed_is_wrong)
    assert {name: counts.asked[name] for name in asked} == asked
    assert {name: counts.correct[name] for name in right} == right


def test_class_mean_and_instance_mean() -> None:
    truth = {1: "chair", 2: "chair", 3: "chair", 4: "chair", 5: "bed"}
    counts = given_mask_retrieval(truth, {1: "chair", 2: "chair", 3: "table", 5: "bed", 9: "bed"})
    assert counts.per_class == {"bed": 1.0, "chair": 0.5}
    assert counts.class_mean == pytest.approx(0.75)
    assert counts.instance_mean == pytest.approx(0.6)
    twice = counts + counts
    assert (twice.asked.total(), twice.instance_mean) == (10, pytest.approx(0.6))


def test_nothing_asked() -> None:
    counts = RetrievalCounts.of([])
    assert math.isnan(counts.class_mean)
    assert math.isnan(counts.instance_mean)


def test_the_overlap_must_exceed_a_quarter() -> None:
    truth, predicted = np.repeat([1, 0], [100, 0]), np.repeat([7, 0], [25, 75])
    counts = predicted_mask_retrieval(count_overlaps(truth, predicted), {1: "bed"}, {7: "bed"})
    assert counts.correct.total() == 0
    predicted[25] = 7
    counts = predicted_mask_retrieval(count_overlaps(truth, predicted), {1: "bed"}, {7: "bed"})
    assert counts.correct.total() == 1


def test_preset_asks_for_17_classes_and_takes_the_mode_of_the_vertices() -> None:
    preset = PRESETS["retrieval"]
    assert len(preset.retrieval_classes) == 17
    names = {category.id: category.name for category in vocabulary("scannet200").categories}
    couch, chair, cup = (next(i for i, n in names.items() if n == name) for name in ("couch", "chair", "cup"))
    instances = np.repeat([1, 2, 3], [200, 200, 200])
    # A third of the couch's vertices bear another class; the cup is none of the 17.
    classes = np.concatenate([[chair] * 60, [couch] * 140, [chair] * 200, [cup] * 200])
    truth = TruthScene(np.zeros((600, 3)), instances, classes, names)
    answers = {1: "sofa", 2: "table", 3: "cup"}
    predicted = PredictedScene(instances=instances, class_names={1: "couch", 2: "chair"}, names_of_truth=answers)
    result = evaluate([("a", truth, predicted)], preset).retrieval
    assert result is not None
    assert result["given_masks"]["per_class"] == {"chair": 0.0, "sofa": 1.0}
    assert result["predicted_masks"]["class_mean"] == 1.0
    assert result["predicted_masks"]["asked"] == {"sofa": 1, "chair": 1}


def test_the_truths_masks_take_the_class_that_most_of_their_vertices_are_predicted() -> None:
    # A chair half of which nobody found and a third of the rest is a table; a table that is all chair; a bed unseen.
    truth_of = np.repeat([1, 2, 3], [120, 100, 100])
    names = {1: "chair", 2: "table", 3: "bed"}
    truth = TruthScene(np.random.default_rng(0).random((320, 3)), truth_of, truth_of, names)
    instances = np.repeat([0, 7, 8, 7, 0], [60, 40, 20, 100, 100])
    predicted = PredictedScene(instances=instances, class_names={7: "chair", 8: "table"})
    result = evaluate([("a", truth, predicted)], PRESETS["retrieval"]).retrieval
    assert result is not None
    given = result["given_masks"]
    assert given["per_class"] == {"bed": 0.0, "chair": 1.0, "table": 0.0}
    assert given["class_mean"] == given["instance_mean"] == 1 / 3
