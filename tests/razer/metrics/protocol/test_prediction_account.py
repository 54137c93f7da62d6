"""What became of each prediction, on a row of squares and in the air; and maps of another scene."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from razer.metrics.presets import PRESETS
from razer.metrics.protocol.evaluation import evaluate
from razer.metrics.scene_pair import PredictedScene, TimedPoses, TruthScene

DEFAULT = PRESETS["default"]
NAMES = {1: "floor", 2: "chair", 3: "table"}
# Patches of 200 vertices side by side: floor, three chairs, a table, and vertices of nobody.
INSTANCES, CLASSES = np.repeat([9, 1, 2, 3, 4, 0], 200), np.repeat([1, 2, 2, 2, 3, 0], 200)


def patches(count: int = 6, seed: int = 0) -> np.ndarray:
    """(200 count, 3) vertices: squares of half a metre, 0.6 m apart."""
    vertices = np.random.default_rng(seed).random((200 * count, 3)) * (0.5, 0.5, 0.0)
    vertices[:, 0] += 0.6 * np.repeat(np.arange(count), 200)
    return vertices


def truth() -> TruthScene:
    return TruthScene(patches(), INSTANCES, CLASSES, NAMES)


def predicted_labels() -> np.ndarray:
    """Floor 90; chair 1 whole as 11; chair 2 as 12 and a piece 13; of chair 3 a part 14; the table not at all; 15 on
    nobody's vertices, and 16 on a part of the floor."""
    labels = np.zeros(1200, int)
    labels[:80] = 90
    labels[80:200] = 16
    labels[200:400] = 11
    labels[400:530] = 12
    labels[530:600] = 13
    labels[600:680] = 14
    labels[1000:1200] = 15
    return labels


RULES = DEFAULT.model_copy(update={"min_region": 50})
THINGS = {90: "floor", 11: "chair", 12: "chair", 13: "chair", 14: "chair", 15: "chair", 16: "chair"}


@pytest.mark.parametrize("own_surface", [False, True])
def test_every_prediction_is_counted_once_for_what_it_lies_on(own_surface):
    predicted = PredictedScene(
        instances=predicted_labels(), class_names=THINGS, scores=dict.fromkeys([*THINGS, 17], 0.9)
    )
    n_air = 0
    if own_surface:
        air = patches(1, 3) + np.array([0, 0, 1.5])  # what no vertex of the truth is near to
        instances = np.concatenate([predicted.instances, np.full(200, 17)])
        predicted = replace(predicted, vertices=np.concatenate([patches(), air]), instances=instances)
        n_air = 1
    result = evaluate([("a", truth(), predicted)], RULES)
    numbers = result.as_json()
    assert (numbers["n_true"], numbers["n_truth"], numbers["missed"], numbers["n_matched"]) == (4, 4, 2, 2)
    # 15 on nothing, and 16 is no chair; what is named floor is.
    assert numbers["n_invented"] == 2 + n_air
    assert numbers["scenes"]["a"]["invented"] == [15, 16, *([17] if n_air else [])]
    assert (numbers["duplicates"], numbers["n_parts"], numbers["n_uncounted"]) == (1, 1, 1)
    assert (numbers["n_predicted"], numbers["n_judged"]) == (7 + n_air, 6 + n_air)
    kinds = ("n_matched", "duplicates", "n_parts", "n_uncounted", "n_invented")
    assert numbers["n_predicted"] == sum(numbers[kind] for kind in kinds)
    # Right are two of those that count.
    assert numbers["calibration"]["bins"][0]["accuracy"] == pytest.approx(2 / (6 + n_air))
    assert numbers["calibration"]["ece"] == pytest.approx(0.9 - 2 / (6 + n_air))


def test_without_names_what_lies_on_the_floor_is_not_held_against_a_map():
    numbers = evaluate([("a", truth(), PredictedScene(instances=predicted_labels()))], RULES).as_json()
    assert [numbers[key] for key in ("n_invented", "n_uncounted", "n_predicted", "n_judged")] == [1, 2, 7, 5]
    assert numbers["calibration"] is None  # no confidences


def test_masks_that_overlap_are_accounted_for_as_well():
    masks = {1: np.arange(200, 400), 2: np.arange(210, 390), 3: np.arange(1000, 1200), 4: np.arange(400, 800)}
    predicted = PredictedScene(masks=masks, scores={1: 0.9, 2: 0.8, 3: 0.7, 4: 0.6})
    result = evaluate([("a", truth(), predicted)], RULES)
    assert (result.n_matched, result.duplicates, result.n_invented, result.n_parts) == (1, 1, 1, 1)


def test_panoptic_quality_by_class_says_how_many_segments():
    predicted = PredictedScene(instances=predicted_labels(), class_names=THINGS)
    per_class = evaluate([("a", truth(), predicted)], RULES).as_json()["panoptic"]["per_class"]
    chair = per_class["chair"]
    assert (chair["n_true"], chair["n_matched"]) == (3, 2)
    assert chair["pq"] == pytest.approx(chair["sq"] * chair["rq"])
    assert per_class["table"] == {"pq": 0, "sq": 0, "rq": 0, "n_true": 1, "n_predicted": 0, "n_matched": 0}


def test_given_poses_are_not_compared_with_themselves():
    poses = TimedPoses(np.arange(4.0), np.tile(np.eye(4), (4, 1, 1)))
    true = replace(truth(), trajectory=poses)
    predicted = PredictedScene(patches(), INSTANCES, trajectory=poses)
    assert evaluate([("a", true, predicted)], DEFAULT).pose is None
    assert evaluate([("a", true, replace(predicted, own_frame=True))], DEFAULT).pose is not None


def test_views_are_counted_in_the_frame_of_the_truth():
    turn = np.diag([-1.0, -1, 1, 1])
    positions = np.tile(np.eye(4), (4, 1, 1))
    positions[:, :3, 3] = np.random.default_rng(0).random((4, 3))
    true = replace(truth(), trajectory=TimedPoses(np.arange(4.0), positions))
    asked = []
    predicted = PredictedScene(
        patches() @ turn[:3, :3].T,
        INSTANCES,
        trajectory=TimedPoses(np.arange(4.0), turn @ positions),
        own_frame=True,
        views_of_truth=lambda poses: asked.append(poses) or {1: 2, 2: 4},
    )
    numbers = evaluate([("a", true, predicted)], DEFAULT).as_json()
    np.testing.assert_allclose(asked[0], positions, atol=1e-9)
    assert numbers["recall_by_views"] == [
        {"views": [0, 0], "n": 2, "recall50": 1.0},
        {"views": [1, 2], "n": 1, "recall50": 1.0},
        {"views": [3, 4], "n": 1, "recall50": 1.0},
    ]
    blind = replace(predicted, views_of_truth=None)
    assert evaluate([("a", true, blind)], DEFAULT).recall_by_views is None
    assert evaluate([("a", true, predicted), ("b", true, blind)], DEFAULT).recall_by_views is None


def test_a_map_of_another_scene_is_doubted_and_one_of_a_part_is_not():
    def warnings(vertices, instances):
        return evaluate([("a", truth(), PredictedScene(vertices, instances))], DEFAULT).as_json()["warnings"]

    assert warnings(patches(seed=0), INSTANCES) == []
    assert warnings(patches()[:400], INSTANCES[:400]) == []
    (warning,) = warnings(patches() + np.array([0, 0, 0.5]), INSTANCES)
    assert "another scene" in warning
    # A floor in common is not enough.
    raised = patches() + np.where(INSTANCES == 9, 0, 0.5)[:, None] * np.array([0, 0, 1])
    assert len(warnings(raised, np.where(INSTANCES == 9, 0, INSTANCES))) == 1
