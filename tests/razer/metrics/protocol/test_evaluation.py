"""The evaluator as a whole: its contract, parts that do not apply, many scenes, and what must never change a number."""

from __future__ import annotations

import gc
import json
import math
import weakref
from collections.abc import Iterator
from dataclasses import replace

import numpy as np
import pytest

from razer.metrics.presets import PRESETS
from razer.metrics.protocol.evaluation import Pair, evaluate
from razer.metrics.scene_pair import PredictedScene, TimedPoses, TruthScene

NAMES = {1: "wall", 2: "chair", 3: "table", 4: "couch"}
DEFAULT = PRESETS["default"]
CLASSES = {1: 1, 2: 2, 3: 2, 4: 3, 5: 4}


def truth_scene(seed: int = 0) -> TruthScene:
    """A wall, two chairs, a table, a couch, and vertices of nobody."""
    instances = np.repeat([1, 2, 3, 4, 5, 0], [300, 150, 200, 250, 400, 100])
    classes = np.array([CLASSES.get(int(i), 0) for i in instances])
    return TruthScene(np.random.default_rng(seed).random((len(instances), 3)), instances, classes, NAMES)


def prediction(truth: TruthScene) -> PredictedScene:
    """The first chair is split, the table is taken for a chair, the couch is missed, one more thing is made up."""
    predicted = np.select([truth.instances == 5], [0], truth.instances)
    predicted[300:420] = 12  # 30 of the 150 vertices stay with 2
    predicted[1300:] = 9
    names = {1: "wall", 2: "chair", 12: "chair", 3: "chair", 4: "chair", 9: "table"}
    return PredictedScene(instances=predicted, class_names=names, scores={12: 0.9, 3: 0.8, 4: 0.7})


def test_contract() -> None:
    truth = truth_scene()
    result = evaluate([("a", truth, prediction(truth))], DEFAULT).as_json()
    assert json.loads(json.dumps(result, allow_nan=False)) == result
    assert set(result) >= {"preset", "settings", "class_agnostic", "class_aware", "semantic", "panoptic", "surface"}
    assert set(result) >= {"duplicates", "missed", "pose"}
    assert result["preset"] == "default"
    assert result["settings"] == json.loads(json.dumps(DEFAULT.model_dump()))
    assert set(result["class_agnostic"]) == {"ap", "ap50", "ap25"}
    assert set(result["class_aware"]) >= {"ap", "ap50", "ap25", "per_class"}
    assert set(result["semantic"]) >= {"miou", "fmiou", "macc", "pixel_accuracy"}
    assert set(result["panoptic"]) >= {"pq", "sq", "rq"}
    assert set(result["surface"]) >= {"accuracy_m", "completeness_m", "fscore_2cm", "fscore_5cm"}
    assert result["pose"] is None
    for masks in ("given_masks", "predicted_masks"):
        assert set(result["retrieval"][masks]) == {"class_mean", "instance_mean", "per_class", "asked"}


def test_known_values() -> None:
    truth = truth_scene()
    result = evaluate([("a", truth, prediction(truth))], DEFAULT)
    assert result.class_aware is not None
    per_class = result.class_aware["per_class"]
    # Chairs: 12 (0.9) and 3 (0.8) are right, the table taken for one is wrong (0.7); piece 2 is too small to exist.
    assert per_class["chair"]["ap50"] == 1.0
    assert per_class["table"]["ap50"] == 0.0
    assert per_class["couch"]["ap50"] == 0.0
    assert "wall" not in per_class
    assert result.class_aware["ap50"] == pytest.approx(1 / 3)
    # Piece 2 is under 100 vertices, thing 9 lies on vertices of nobody.
    assert (result.n_truth, result.missed, result.duplicates) == (4, 1, 0)
    assert [m["truth"] for m in result.scenes["a"]["matches"]] == [2, 3, 4]
    assert [(w.truth, w.predicted, w.truth_class) for w in result.worst[:2]] == [(5, None, "couch"), (2, 12, "chair")]
    assert result.worst[1].iou == pytest.approx(120 / 150)
    assert result.confusion is not None
    names, counts = result.confusion["names"], result.confusion["counts"]
    assert counts[names.index("table")][names.index("chair")] == 250
    assert counts[names.index("couch")][0] == 400
    assert sum(map(sum, counts)) == 1400
    curve = result.curves["chair"]
    assert (curve.precision.tolist(), curve.recall.tolist()) == ([pytest.approx(2 / 3), 1, 1], [1, 1, 0.5])


def test_duplicates_are_second_parts_of_a_matched_truth() -> None:
    truth = truth_scene()
    predicted = np.where(truth.instances == 5, 5, 0)
    predicted[np.flatnonzero(predicted)[:150]] = 6
    result = evaluate([("a", truth, PredictedScene(instances=predicted))], DEFAULT)
    assert (result.duplicates, result.missed) == (1, 3)
    assert result.scenes["a"]["duplicates"] == (6,)


def test_parts_that_do_not_apply_are_null() -> None:
    truth = truth_scene()
    no_names = evaluate([("a", truth, PredictedScene(instances=truth.instances))], DEFAULT).as_json()
    assert (no_names["class_aware"], no_names["semantic"], no_names["pose"]) == (None, None, None)
    assert (no_names["panoptic"]["classes"], no_names["panoptic"]["pq"]) == ("agnostic", 1.0)
    only_classes = PredictedScene(classes=truth.classes, vertex_class_names=NAMES)
    semantic = evaluate([("a", truth, only_classes)], DEFAULT).as_json()
    assert semantic["semantic"]["miou"] == 1.0
    for part in ("class_agnostic", "class_aware", "panoptic", "duplicates", "missed", "retrieval"):
        assert semantic[part] is None
    masks = evaluate([("a", truth, PredictedScene(masks={1: np.arange(300, 450)}))], DEFAULT).as_json()
    assert masks["surface"] is None
    nothing = evaluate([], DEFAULT).as_json()
    assert {nothing[part] for part in ("class_agnostic", "class_aware", "semantic", "surface", "pose")} == {None}


def test_a_truth_without_classes_is_evaluated_without_them() -> None:
    truth = replace(truth_scene(), classes=np.zeros(1400, int), class_names={})
    result = evaluate([("a", truth, prediction(truth))], DEFAULT).as_json()
    assert (result["class_aware"], result["semantic"]) == (None, None)
    assert result["n_truth"] == 5


def test_no_prediction_at_all_is_a_zero_not_a_null() -> None:
    truth = truth_scene()
    result = evaluate([("a", truth, PredictedScene(instances=np.zeros(1400, int)))], DEFAULT).as_json()
    assert result["class_agnostic"]["ap50"] == 0.0
    assert result["class_aware"]["ap50"] == 0.0
    assert result["missed"] == 4


def test_vertices_nobody_saw_do_not_count() -> None:
    truth = truth_scene()
    unseen = replace(truth, evaluated=truth.instances != 5)
    result = evaluate([("a", unseen, prediction(truth))], DEFAULT)
    assert result.missed == 0
    assert result.class_aware is not None
    assert "couch" not in result.class_aware["per_class"]
    masks = {i: np.flatnonzero(prediction(truth).instances == i) for i in (2, 3, 4, 12)}
    as_masks = PredictedScene(masks=masks, class_names=prediction(truth).class_names, scores=prediction(truth).scores)
    from_masks = evaluate([("a", unseen, as_masks)], DEFAULT)
    assert from_masks.class_agnostic == result.class_agnostic
    assert from_masks.class_aware == result.class_aware


def test_masks_as_numbers_or_truth_values_and_labels_agree() -> None:
    truth = truth_scene()
    labels = prediction(truth)
    assert labels.instances is not None
    ids = [int(i) for i in np.unique(labels.instances) if i]
    named = {"class_names": labels.class_names, "scores": labels.scores}
    expected = evaluate([("a", truth, labels)], DEFAULT).as_json() | {"surface": None}
    for masks in ({i: labels.instances == i for i in ids}, {i: np.flatnonzero(labels.instances == i) for i in ids}):
        result = evaluate([("a", truth, PredictedScene(masks=masks, **named))], DEFAULT).as_json()
        result["scenes"]["a"]["surface"] = expected["scenes"]["a"]["surface"]
        assert result == expected


def test_ids_and_vertex_order_do_not_matter() -> None:
    truth, order = truth_scene(), np.random.default_rng(1).permutation(1400)
    labels = prediction(truth)
    assert labels.instances is not None
    shuffled = TruthScene(truth.vertices[order], truth.instances[order], truth.classes[order], NAMES)
    result = evaluate([("a", shuffled, replace(labels, instances=labels.instances[order]))], DEFAULT).as_json()
    assert result == evaluate([("a", truth, labels)], DEFAULT).as_json()


def test_pooled_ranks_all_scenes_together_and_mean_each_alone() -> None:
    truth = truth_scene()
    good = PredictedScene(instances=np.where(truth.instances == 5, 5, 0), scores={5: 0.2})
    bad_labels = np.where(truth.instances > 3, 4, 0)  # the couch and the table as one, overlap 400 / 650
    bad = PredictedScene(instances=np.where(truth.instances == 1, 0, bad_labels), scores={4: 0.9})
    one, two = ("good", truth, good), ("bad", truth, bad)
    pooled = evaluate([one, two], DEFAULT).class_agnostic
    mean = evaluate([one, two], DEFAULT.model_copy(update={"instances_over_scenes": "mean"})).class_agnostic
    alone = [evaluate([pair], DEFAULT).class_agnostic for pair in (one, two)]
    assert mean is not None
    assert pooled is not None
    assert mean["ap"] == pytest.approx(np.mean([a["ap"] for a in alone if a is not None]))
    # Each finds one of four; of eight two are found, and in the pooled ranking the worse one stands first.
    assert pooled["ap"] != pytest.approx(mean["ap"])
    assert pooled["ap50"] == pytest.approx((0.25 - 0) / 2 + 0.25 / 2, abs=1e-12)


def test_only_one_scene_is_held() -> None:
    alive: list[weakref.ref] = []

    def pairs() -> Iterator[Pair]:
        for seed in range(4):
            gc.collect()
            assert sum(ref() is not None for ref in alive) == 0
            truth = truth_scene(seed)
            alive.append(weakref.ref(truth.vertices))
            yield str(seed), truth, prediction(truth)
            del truth

    assert evaluate(pairs(), DEFAULT).n_truth == 16


def test_a_surface_in_the_frame_of_its_own_trajectory_is_moved_first() -> None:
    truth = truth_scene()
    angle = 0.4
    turn = np.eye(4)
    turn[:2, :2] = [[math.cos(angle), -math.sin(angle)], [math.sin(angle), math.cos(angle)]]
    turn[:3, 3] = [1, 2, 3]
    poses = np.tile(np.eye(4), (8, 1, 1))
    poses[:, :3, 3] = np.random.default_rng(0).random((8, 3))
    stamps = np.arange(8) / 10
    truth = replace(truth, trajectory=TimedPoses(stamps, poses))
    moved = PredictedScene(
        vertices=truth.vertices @ turn[:3, :3].T + turn[:3, 3],
        instances=truth.instances,
        trajectory=TimedPoses(stamps, turn @ poses),
        own_frame=True,
    )
    result = evaluate([("a", truth, moved)], DEFAULT)
    assert result.class_agnostic is not None
    assert result.surface is not None
    assert result.pose is not None
    assert result.class_agnostic["ap"] == 1.0
    assert result.surface["accuracy_m"] == pytest.approx(0, abs=1e-9)
    assert result.pose["ate_rmse_m"] == pytest.approx(0, abs=1e-9)
    assert result.pose["tracked"] == 1.0
    left = evaluate([("a", truth, replace(moved, own_frame=False))], DEFAULT)
    assert left.class_agnostic is not None
    assert left.class_agnostic["ap25"] == 0.0


def test_a_surface_whose_path_is_nearly_flat_is_moved_by_where_its_cameras_looked() -> None:
    truth, t = truth_scene(), np.linspace(0, 2 * np.pi, 40)
    poses = np.tile(np.eye(4), (40, 1, 1))
    poses[:, :3, 3] = np.stack([0.42 * np.sin(t), 0.155 * np.cos(2 * t), 0.014 * np.cos(5 * t)], axis=1)
    estimated = poses.copy()
    estimated[:, 2, 3] += 0.04 * np.cos(2 * t)
    stamps = np.arange(40) / 10
    own = PredictedScene(
        vertices=truth.vertices, instances=truth.instances, trajectory=TimedPoses(stamps, estimated), own_frame=True
    )
    result = evaluate([("a", replace(truth, trajectory=TimedPoses(stamps, poses)), own)], DEFAULT)
    assert result.surface is not None
    assert result.pose is not None
    assert result.surface["accuracy_m"] < 0.02  # by positions alone it was turned by 13 degrees
    assert result.pose["rotation_rmse_deg"] < 1
    (cause,) = result.pose["degenerate"]
    assert "nearly flat" in cause


def test_names_that_no_list_has_are_reported() -> None:
    truth = truth_scene()
    strange = replace(prediction(truth), class_names={2: "chair", 3: "zorb"})
    assert evaluate([("a", truth, strange)], PRESETS["scannet200"]).unknown_names == ("zorb",)


@pytest.mark.parametrize(
    ("wrong", "message"),
    [
        (PredictedScene(instances=np.ones(3, int)), "one of each"),
        (PredictedScene(classes=np.ones(3, int), vertex_class_names=NAMES), "one of each"),
        (PredictedScene(masks={5: np.array([1400])}), "mask 5 names vertices"),
        (PredictedScene(masks={5: np.ones(3, bool)}), "one of each"),
    ],
)
def test_predictions_that_do_not_fit_are_refused(wrong: PredictedScene, message: str) -> None:
    with pytest.raises(ValueError, match=message):
        evaluate([("a", truth_scene(), wrong)], DEFAULT)
