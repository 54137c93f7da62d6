"""Instance AP against a literal transcription of the benchmark's rules, cases with known answers, and invariants."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from razer.metrics.instances.instance_ap import (
    ANY_CLASS,
    AP_THRESHOLDS,
    ApSettings,
    Scene,
    instance_ap,
    pooled_instance_ap,
)
from razer.metrics.instances.matching import count_overlaps, match_predictions
from razer.metrics.instances.precision_recall import average_precision
from razer.metrics.surface.nearest_vertices import transfer_labels


def labels(*runs: tuple[int, int]) -> np.ndarray:
    """(id, how many vertices) runs as one label per vertex."""
    return np.concatenate([np.full(count, number) for number, count in runs])


def vertex_sets(scene: Scene, label: object) -> tuple[dict[int, set[int]], dict[int, set[int]], set[int]]:
    """The vertices of each truth and prediction of a class, and the void ones."""
    truths: dict[int, set[int]] = {}
    predictions: dict[int, set[int]] = {}
    void: set[int] = set()
    for vertex, (t, p) in enumerate(zip(scene.truth.tolist(), scene.predicted.tolist(), strict=True)):
        known = t > 0 and (scene.truth_classes is None or t in scene.truth_classes)
        if not known or (scene.void is not None and scene.void[vertex]):
            void.add(vertex)
        elif scene.truth_classes is None or scene.truth_classes[t] == label:
            truths.setdefault(t, set()).add(vertex)
        if p > 0 and (scene.truth_classes is None or (scene.predicted_classes or {}).get(p) == label):
            predictions.setdefault(p, set()).add(vertex)
    return truths, predictions, void


def overlap(a: set[int], b: set[int]) -> float:
    return len(a & b) / len(a | b)


def slow_truths(
    truths: dict[int, set[int]], predictions: dict[int, set[int]], scores: dict[int, float], threshold: float
) -> tuple[list[int], list[float], int]:
    """Right and wrong outcomes, their scores and the number of misses, truth by truth."""
    y_true: list[int] = []
    y_score: list[float] = []
    misses = 0
    visited: set[int] = set()
    for _, truth in sorted(truths.items()):
        best = None
        for p, prediction in sorted(predictions.items()):
            if p in visited or not overlap(truth, prediction) > threshold:
                continue
            if best is None:
                best = scores.get(p, 1.0)
                visited.add(p)
            else:
                y_true.append(0)
                y_score.append(min(best, scores.get(p, 1.0)))
                best = max(best, scores.get(p, 1.0))
        if best is None:
            misses += 1
        else:
            y_true.append(1)
            y_score.append(best)
    return y_true, y_score, misses


def slow_wrong(
    truths: dict[int, set[int]], prediction: set[int], void: set[int], threshold: float, min_region: int
) -> bool:
    """Whether an unmatched prediction counts as wrong."""
    if any(overlap(t, prediction) > threshold for t in truths.values()):
        return False
    small = [t for t in truths.values() if len(t) < min_region]
    ignored = len(prediction & void) + sum(len(prediction & t) for t in small)
    return ignored / len(prediction) <= threshold


def slow_ap(scenes: list[Scene], threshold: float, min_region: int, label: object) -> float:
    """The benchmark's rules, one scene, truth, prediction and vertex at a time."""
    y_true: list[int] = []
    y_score: list[float] = []
    misses, has_truth, has_prediction = 0, False, False
    for scene in scenes:
        all_truths, predictions, void = vertex_sets(scene, label)
        predictions = {p: v for p, v in predictions.items() if len(v) >= min_region}
        truths = {t: v for t, v in all_truths.items() if len(v) >= min_region}
        has_truth, has_prediction = has_truth or bool(truths), has_prediction or bool(predictions)
        right, scored, missed = slow_truths(truths, predictions, dict(scene.scores), threshold)
        wrong = [p for p, v in predictions.items() if slow_wrong(all_truths, v, void, threshold, min_region)]
        y_true += right + [0] * len(wrong)
        y_score += scored + [scene.scores.get(p, 1.0) for p in wrong]
        misses += missed
    if not has_truth:
        return math.nan
    return slow_area(y_true, y_score, misses) if has_prediction else 0.0


def slow_area(y_true: list[int], y_score: list[float], hard_misses: int) -> float:
    precision, recall = [], []
    for cut in sorted(set(y_score)):
        tp = sum(t for t, s in zip(y_true, y_score, strict=True) if s >= cut)
        fp = sum(1 - t for t, s in zip(y_true, y_score, strict=True) if s >= cut)
        fn = hard_misses + sum(t for t, s in zip(y_true, y_score, strict=True) if s < cut)
        precision.append(tp / (tp + fp))
        recall.append(tp / (tp + fn) if tp + fn else 0.0)
    precision.append(1.0)
    recall.append(0.0)
    padded = [recall[0], *recall, 0.0]
    return sum(p * 0.5 * (padded[i] - padded[i + 2]) for i, p in enumerate(precision))


@st.composite
def scenes(draw: st.DrawFn) -> Scene:
    """Blocks of vertices with random labels, classes, scores with ties, and void."""
    blocks = draw(
        st.lists(st.tuples(st.integers(0, 5), st.integers(0, 6), st.integers(1, 12), st.booleans()), max_size=14)
    )
    truth = labels(*[(t, n) for t, _, n, _ in blocks]) if blocks else np.zeros(0, int)
    predicted = labels(*[(p, n) for _, p, n, _ in blocks]) if blocks else np.zeros(0, int)
    void = np.repeat([v for *_, v in blocks], [n for *_, n, _ in blocks]).astype(bool)
    scores = {p: draw(st.sampled_from([0.2, 0.5, 0.9])) for p in range(1, 7)}
    if not draw(st.booleans()):
        return Scene(truth, predicted, scores, void=void & draw(st.booleans()))
    names = st.sampled_from(["chair", "table"])
    truth_classes = {t: draw(names) for t in range(1, 6) if draw(st.integers(0, 4))}
    return Scene(truth, predicted, scores, truth_classes, {p: draw(names) for p in range(1, 7)})


def same(a: float, b: float) -> bool:
    return (math.isnan(a) and math.isnan(b)) or a == pytest.approx(b, abs=1e-12)


@settings(max_examples=250, deadline=None)
@given(scenes(), st.sampled_from([1, 4, 10]))
def test_equals_the_literal_rules(scene: Scene, min_region: int) -> None:
    result = instance_ap(scene, ApSettings(min_region=min_region))
    for name, class_ap in result.per_class.items():
        assert same(class_ap.ap50, slow_ap([scene], 0.5, min_region, name))
        assert same(class_ap.ap25, slow_ap([scene], 0.25, min_region, name))
        expected = np.mean([slow_ap([scene], t, min_region, name) for t in AP_THRESHOLDS])
        assert same(class_ap.ap, float(expected))


@settings(max_examples=80, deadline=None)
@given(st.lists(scenes(), min_size=2, max_size=3))
def test_pooled_scenes_equal_the_literal_rules(several: list[Scene]) -> None:
    several = [Scene(s.truth, s.predicted, s.scores, void=s.void) for s in several]
    result = pooled_instance_ap(several, ApSettings(min_region=4))
    assert same(result.ap50, slow_ap(several, 0.5, 4, ANY_CLASS))
    assert same(result.ap25, slow_ap(several, 0.25, 4, ANY_CLASS))


@settings(max_examples=60, deadline=None)
@given(scenes(), st.randoms(use_true_random=False))
def test_names_and_order_of_vertices_do_not_matter(scene: Scene, random: object) -> None:
    scene = Scene(scene.truth, scene.predicted, scene.scores)
    before = instance_ap(scene, ApSettings(min_region=3))
    order = np.array(random.sample(range(len(scene.truth)), len(scene.truth)), int)  # type: ignore[attr-defined]
    renamed = np.where(scene.predicted > 0, scene.predicted + 40, 0)
    moved = Scene(scene.truth[order], renamed[order], {p + 40: s for p, s in scene.scores.items()})
    after = instance_ap(moved, ApSettings(min_region=3))
    assert same(before.ap, after.ap)
    assert same(before.ap25, after.ap25)
    assert [(m.truth, m.predicted + 40) for m in before.matches] == [(m.truth, m.predicted) for m in after.matches]


@settings(max_examples=60, deadline=None)
@given(scenes())
def test_truth_predicts_itself_perfectly(scene: Scene) -> None:
    perfect = instance_ap(Scene(scene.truth, scene.truth, scene.scores), ApSettings(min_region=5))
    if perfect.matches:
        assert (perfect.ap, perfect.ap50, perfect.ap25) == (1.0, 1.0, 1.0)
    assert perfect.duplicates == ()
    assert perfect.missed == ()


def test_thresholds_stop_at_090() -> None:
    assert AP_THRESHOLDS == (0.5, 0.55, 0.6, 0.65, 0.7, 0.75, 0.8, 0.85, 0.9)


def test_one_of_two_found() -> None:
    # Precision 1 up to recall 1/2. The last step of the convolution runs from recall 1/2 to 0.
    result = instance_ap(Scene(labels((1, 200), (2, 200)), labels((7, 200), (0, 200))))
    assert result.ap50 == pytest.approx(0.5)
    assert result.missed == (2,)
    assert [(m.truth, m.predicted, m.iou) for m in result.matches] == [(1, 7, 1.0)]


def test_overlap_must_exceed_the_threshold() -> None:
    # 200 of 400 shared: exactly one half is no match at 0.5, but is one at 0.25.
    result = instance_ap(Scene(labels((1, 400)), labels((3, 200), (0, 200))))
    assert result.ap50 == 0.0
    assert result.ap25 == 1.0


def test_average_counts_the_thresholds_passed() -> None:
    # IoU 0.72 passes .5 .55 .6 .65 .7: five of nine.
    result = instance_ap(Scene(labels((1, 1000)), labels((3, 720), (0, 280))))
    assert result.ap == pytest.approx(5 / 9)


def test_second_prediction_on_one_truth_is_wrong_with_the_lower_score() -> None:
    truth, predicted = labels((1, 1000)), labels((1, 520), (2, 480))
    result = instance_ap(Scene(truth, predicted, {1: 0.3, 2: 0.9}))
    # At 0.25 both are close enough; 0.9 is right and 0.3 wrong, which costs nothing after full recall.
    assert result.ap25 == 1.0
    outcomes = match_predictions(count_overlaps(truth, predicted), np.array([0.3, 0.9]), 0.25, 100)
    ranked = zip(outcomes.scores.tolist(), outcomes.is_true_positive.tolist(), strict=True)
    assert sorted(ranked) == [(0.3, False), (0.9, True)]
    assert result.duplicates == (2,)


def test_tied_scores_form_one_point() -> None:
    # One right and one wrong at the same score: one point (precision 1/2, recall 1) and the last (1, 0).
    result = average_precision(np.array([0.5, 0.5]), np.array([True, False]), 0)
    assert result == pytest.approx(0.5 * 0.5 + 1.0 * 0.5)


def test_ranked_mistake_costs_less_than_a_tied_one() -> None:
    ranked = average_precision(np.array([0.9, 0.1]), np.array([True, False]), 0)
    # Points (1/2, 1), (1, 1), (1, 0): steps 0, 1/2, 1/2.
    assert ranked == pytest.approx(1.0)


def test_prediction_on_void_does_not_count() -> None:
    truth, predicted = labels((1, 300), (0, 300)), labels((1, 300), (2, 300))
    assert instance_ap(Scene(truth, predicted)).ap50 == 1.0
    # On a truth that is looked for the same prediction is wrong: 300 of its 900 vertices.
    wrong = instance_ap(Scene(labels((1, 300), (5, 900)), np.append(predicted, np.zeros(600, int))))
    # One right and one wrong, tied, one of two found: points (1/2, 1/2) and (1, 0).
    assert wrong.ap50 == pytest.approx(0.5 * 0.25 + 1.0 * 0.25)


def test_void_share_must_exceed_the_threshold() -> None:
    # Half of prediction 2 on void, half on truth 1: at 0.5 it counts as wrong, at 0.25 it is ignored.
    truth = labels((1, 1000), (0, 100))
    predicted = labels((1, 900), (2, 200))
    tied = {1: 0.5, 2: 0.5}
    result = instance_ap(Scene(truth, predicted, tied))
    assert result.ap50 == pytest.approx(0.75)
    assert result.ap25 == 1.0


def test_vertices_of_truths_too_small_are_ignored_like_void() -> None:
    truth, predicted = labels((1, 300), (2, 99), (3, 201)), labels((1, 300), (9, 150), (0, 150))
    result = instance_ap(Scene(truth[:399], predicted[:399]))
    assert result.ap50 == 1.0
    assert result.missed == ()


def test_small_predictions_do_not_exist() -> None:
    truth = labels((1, 300), (2, 120))
    result = instance_ap(Scene(truth, labels((1, 300), (4, 99), (0, 21))))
    assert result.missed == (2,)
    assert result.ap50 == pytest.approx(0.5)
    assert result.duplicates == ()


def test_empty_sides() -> None:
    nothing = np.zeros(500, int)
    assert math.isnan(instance_ap(Scene(nothing, labels((1, 500)))).ap)
    assert instance_ap(Scene(labels((1, 500)), nothing)).ap == 0.0
    assert math.isnan(instance_ap(Scene(np.zeros(0, int), np.zeros(0, int))).ap50)


def test_classes_are_separate_and_absent_ones_leave_the_mean() -> None:
    truth = labels((1, 200), (2, 200), (3, 200))
    predicted = labels((1, 200), (2, 200), (3, 200))
    classes = {1: "chair", 2: "chair", 3: "table", 9: "bed"}
    result = instance_ap(Scene(truth, predicted, {}, classes, {1: "chair", 2: "table", 3: "table"}))
    assert result.per_class["chair"].ap50 == pytest.approx(0.5)
    # One right, one wrong, tied: 0.75, as above.
    assert result.per_class["table"].ap50 == pytest.approx(0.75)
    assert math.isnan(result.per_class["bed"].ap)
    assert result.ap50 == pytest.approx((0.5 + 0.75) / 2)


def test_truth_of_no_evaluated_class_is_void() -> None:
    truth, predicted = labels((1, 200), (2, 200)), labels((1, 200), (2, 200))
    result = instance_ap(Scene(truth, predicted, {}, {1: "chair"}, {1: "chair", 2: "chair"}))
    assert result.ap == 1.0


def test_duplicates_lie_mostly_in_a_matched_truth() -> None:
    truth = labels((1, 1000), (2, 400))
    # 2 lies in the matched truth 1; 3 is half in it and half outside; 4 is an unmatched part of the missed truth 2.
    predicted = labels((1, 600), (2, 200), (3, 200), (3, 200), (4, 150), (0, 50))
    result = instance_ap(Scene(truth, predicted))
    assert result.duplicates == (2,)
    assert result.missed == (2,)


def test_label_lengths_must_agree() -> None:
    with pytest.raises(ValueError, match="one of each per vertex"):
        count_overlaps(np.ones(3, int), np.ones(4, int))


@settings(max_examples=50, deadline=None)
@given(st.integers(0, 30), st.integers(0, 30), st.integers(0, 10_000))
def test_transfer_equals_all_pairs(n_predicted: int, n_truth: int, seed: int) -> None:
    rng = np.random.default_rng(seed)
    source, target = rng.random((n_predicted, 3)), rng.random((n_truth, 3))
    ids = rng.integers(0, 4, n_predicted)
    distance = np.linalg.norm(target[:, None] - source, axis=2)
    for k in (1, 3):
        expected = []
        for row in distance:
            near = [ids[i] for i in np.argsort(row)[:k] if row[i] <= 0.3]
            expected.append(min(near, key=lambda label: (-near.count(label), label)) if near else 0)
        assert transfer_labels(source, ids, target, 0.3, k).tolist() == expected


def test_transfer_reaches_exactly_the_distance() -> None:
    source, target = np.zeros((1, 3)), np.array([[0.5, 0, 0], [0.500001, 0, 0]])
    assert transfer_labels(source, np.array([4]), target, 0.5).tolist() == [4, 0]
