"""A prediction on the vertices of the truth: confidences by size, overlapping masks, classes by majority."""

from __future__ import annotations

import numpy as np
import pytest

from razer.metrics.presets import PRESETS
from razer.metrics.protocol.scene_labels import labels_on_truth
from razer.metrics.protocol.vertex_labels import flatten_masks, relabel
from razer.metrics.protocol.vertex_masks import VertexMasks
from razer.metrics.scene_pair import PredictedScene, TruthScene

NAMES = {1: "chair", 2: "bed"}


def truth_of(classes: np.ndarray, instances: np.ndarray) -> TruthScene:
    return TruthScene(np.random.default_rng(0).random((len(classes), 3)), instances, classes, NAMES)


def test_confidence_is_the_share_of_the_largest_of_the_class_in_the_scene() -> None:
    instances = np.repeat([1, 2, 3, 4, 0], [40, 80, 20, 30, 5])
    truth = truth_of(np.ones(175, int), instances)
    predicted = PredictedScene(instances=instances, class_names={1: "chair", 2: "chair", 3: "chair", 4: "bed"})
    labels = labels_on_truth(truth, predicted, PRESETS["default"].model_copy(update={"score": "size_share"}))
    assert labels.scores == {1: 0.5, 2: 1.0, 3: 0.25, 4: 1.0}
    masks = PredictedScene(masks={5: np.arange(10), 6: np.arange(40)}, class_names={5: "bed", 6: "bed"})
    labels = labels_on_truth(truth, masks, PRESETS["default"].model_copy(update={"score": "size_share"}))
    assert labels.scores == {5: 0.25, 6: 1.0}


def test_of_overlapping_masks_the_highest_score_wins_then_the_lowest_id() -> None:
    masks = {1: np.array([0, 1, 2]), 2: np.array([1, 2, 3]), 3: np.array([2, 3, 4])}
    assert flatten_masks(masks, {1: 0.5, 2: 0.5, 3: 0.9}, 6).tolist() == [1, 1, 3, 3, 3, 0]
    assert flatten_masks(masks, {}, 6).tolist() == [1, 1, 1, 2, 3, 0]


def test_a_true_instance_has_the_class_of_most_of_its_vertices() -> None:
    # Three to two, a tie (the lower number), and one whose unlabelled vertices do not count.
    instances = np.repeat([7, 8, 9], [5, 4, 4])
    classes = np.array([2, 2, 2, 1, 1, 2, 1, 2, 1, 0, 0, 0, 2])
    labels = labels_on_truth(truth_of(classes, instances), PredictedScene(instances=instances), PRESETS["default"])
    assert labels.truth_instance_classes == {7: 2, 8: 1, 9: 2}


def test_instances_and_classes_of_a_surface_have_their_own_rules() -> None:
    truth = TruthScene(np.array([[0.0, 0, 0], [1, 0, 0]]), np.array([1, 2]), np.array([1, 2]), NAMES)
    surface = np.array([[0.01, 0, 0], [0.02, 0, 0], [0.03, 0, 0], [1.2, 0, 0]])
    predicted = PredictedScene(
        surface, instances=np.array([5, 6, 6, 7]), class_names={5: "chair", 6: "bed", 7: "bed"}, scores={5: 0.3}
    )
    rules = PRESETS["default"].model_copy(update={"semantic_k": 3, "semantic_max_m": None})
    labels = labels_on_truth(truth, predicted, rules)
    assert np.asarray(labels.predicted_instances).tolist() == [5, 0]
    assert labels.predicted_classes is not None
    assert labels.predicted_classes.tolist() == [2, 2]


def test_labels_without_a_number_become_none() -> None:
    assert relabel(np.array([4, 9, 4, 0]), {4: 11, 0: 3}).tolist() == [11, 0, 11, 3]


def test_a_truth_is_checked_at_birth() -> None:
    with pytest.raises(ValueError, match="one instance, class"):
        TruthScene(np.zeros((3, 3)), np.zeros(2, int), np.zeros(3, int), {})
    with pytest.raises(ValueError, match="finite"):
        TruthScene(np.full((1, 3), np.nan), np.zeros(1, int), np.zeros(1, int), {})
    with pytest.raises(ValueError, match="not both"):
        PredictedScene(instances=np.zeros(3, int), masks={})
    with pytest.raises(ValueError, match="no masks"):
        PredictedScene(np.zeros((2, 3)), np.zeros(3, int))


def test_masks_are_the_same_as_numbers_or_truth_values_on_all_vertices_or_those_that_count():
    rng = np.random.default_rng(0)
    inside = {number: rng.random(300) < 0.3 for number in (7, 2)}
    counts = rng.random(300) < 0.6
    for given in (inside, {number: np.flatnonzero(mask)[::-1] for number, mask in inside.items()}):
        masks = VertexMasks(given, 300)
        assert list(masks) == [2, 7]
        for number, mask in inside.items():
            assert masks[number].tolist() == np.flatnonzero(mask).tolist()
            assert masks.among(counts)[number].tolist() == np.flatnonzero(mask[counts]).tolist()
    with pytest.raises(ValueError, match="do not have"):
        VertexMasks({1: np.array([300])}, 300)
    with pytest.raises(ValueError, match="299 predicted labels"):
        VertexMasks({1: np.ones(299, bool)}, 300)
