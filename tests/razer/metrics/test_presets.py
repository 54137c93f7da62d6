"""Presets: the facts of the protocols, names compared across lists, and truth against itself under each preset."""

from __future__ import annotations

import json

import numpy as np
import pytest
from pydantic import ValidationError

from razer.metrics.class_table import ClassTable
from razer.metrics.preset import Preset
from razer.metrics.presets import PRESETS
from razer.metrics.protocol.evaluation import evaluate
from razer.metrics.scene_pair import PredictedScene, TruthScene
from razer.vocabulary import vocabulary

NAMES = {category.id: category.name for category in vocabulary("scannet200").categories}
ROOM = ("wall", "floor", "chair", "chair", "couch", "bed", "table", "toilet", "window", "cabinet")


def room() -> TruthScene:
    """Things of 144 vertices on a plane, some in two classes' lists only, with unlabelled vertices between them."""
    numbers = {name: number for number, name in NAMES.items()}
    points, instances, classes = [], [], []
    for i, name in enumerate((*ROOM, None)):
        x, y = np.meshgrid(np.arange(12) * 0.02, np.arange(12) * 0.02)
        shift = 0.22 * i  # the first column of each thing lies where the last one of its neighbour does
        points.append(np.stack([x + shift, y, 0 * x], axis=-1).reshape(-1, 3))
        instances += [i + 1 if name else 0] * 144
        classes += [numbers[name] if name else 0] * 144
    return TruthScene(np.concatenate(points), np.array(instances), np.array(classes), NAMES)


def itself(truth: TruthScene, surface: bool) -> PredictedScene:
    return PredictedScene(
        vertices=truth.vertices if surface else None,
        instances=truth.instances,
        class_names={i + 1: name for i, name in enumerate(ROOM)},
        classes=truth.classes,
        vertex_class_names=NAMES,
    )


@pytest.mark.parametrize("name", PRESETS)
@pytest.mark.parametrize("surface", [False, True], ids=["labels", "surface"])
def test_truth_against_itself_is_exactly_one(name: str, surface: bool) -> None:
    truth, preset = room(), PRESETS[name]
    result = evaluate([("room", truth, itself(truth, surface))], preset).as_json()
    assert result["class_agnostic"] == {"ap": 1.0, "ap50": 1.0, "ap25": 1.0}
    assert [result["class_aware"][key] for key in ("ap", "ap50", "ap25")] == [1.0] * 3
    assert [result["panoptic"][key] for key in ("pq", "sq", "rq")] == [1.0] * 3
    assert [result["panoptic"]["class_agnostic"][key] for key in ("pq", "sq", "rq")] == [1.0] * 3
    assert [result["surface"][key] for key in ("accuracy_m", "completeness_m", "chamfer_m")] == [0.0] * 3
    assert [result["surface"][key] for key in ("fscore_2cm", "fscore_5cm")] == [1.0] * 2
    assert result["retrieval"]["predicted_masks"]["class_mean"] == 1.0
    assert (result["duplicates"], result["missed"]) == (0, 0)
    semantic = [result["semantic"][key] for key in ("miou", "fmiou", "macc", "pixel_accuracy")]
    if preset.semantic_k == 1:
        assert semantic == [1.0] * 4
    else:
        # A majority of five is not the identity where things touch.
        assert all(0.8 < value < 1.0 for value in semantic)


@pytest.mark.parametrize("name", PRESETS)
def test_presets_come_back_from_what_they_print(name: str) -> None:
    preset = PRESETS[name]
    assert preset.name == name
    assert Preset.model_validate(json.loads(json.dumps(preset.model_dump()))) == preset


def test_facts_of_the_protocols() -> None:
    scenenn, hovsg = PRESETS["scenenn"], PRESETS["hovsg"]
    assert len(scenenn.instance_classes) == 18
    assert [len(classes) for classes in scenenn.class_lists.values()] == [9]
    assert len(scenenn.scenes) == 10
    assert (scenenn.voxel_size_m, scenenn.truncation_voxels, scenenn.depth_max_m) == (0.01, 5, 3)
    assert len(hovsg.scenes) == 13
    assert (hovsg.semantic_k, hovsg.semantic_max_m, hovsg.every) == (5, None, 10)
    assert PRESETS["scannet200"].thresholds == (0.5, 0.55, 0.6, 0.65, 0.7, 0.75, 0.8, 0.85, 0.9)
    assert {preset.text_template for preset in PRESETS.values()} == {None}
    assert len(PRESETS["ovo"].semantic_classes) == len(set(PRESETS["ovo"].semantic_classes)) == 51
    assert [len(PRESETS["conceptgraphs"].semantic_ignored)] == [6]
    assert sorted(map(len, PRESETS["conceptgraphs"].semantic_lists.values())) == [1, 4]
    assert PRESETS["rayfronts"].voxel_size_m == 0.05
    assert (PRESETS["ovi-map"].semantic_k, PRESETS["ovi-map"].semantic_max_m) == (1, 0.05)


def test_every_option_is_described_and_wrong_ones_are_refused() -> None:
    assert all(field.description for field in Preset.model_fields.values())
    with pytest.raises(ValidationError):
        Preset(semantic_k=0)
    with pytest.raises(ValidationError):
        Preset(unheard_of=1)  # type: ignore[call-arg]


def test_class_of_an_instance_is_its_own_or_its_vertices() -> None:
    truth = room()
    chair, bed = (next(i for i, n in NAMES.items() if n == name) for name in ("chair", "bed"))
    classes = np.where(np.arange(len(truth.classes)) % 3 > 0, truth.classes, bed)  # two thirds of each are right
    predicted = PredictedScene(
        instances=truth.instances, class_names={3: "bed"}, classes=classes, vertex_class_names=NAMES
    )
    assert truth.classes[truth.instances == 3][0] == chair

    def recalls(rule: str) -> list[float]:
        preset = PRESETS["default"].model_copy(update={"instance_class": rule, "score": "one"})
        result = evaluate([("a", truth, predicted)], preset).class_aware
        assert result is not None
        return [result["per_class"][name]["ap50"] for name in ("chair", "couch")]

    # The third instance is called a bed, though its vertices are those of a chair; the others bear no name.
    assert recalls("own") == [0.5, 1.0]
    assert recalls("vertices") == [1.0, 1.0]


@pytest.mark.parametrize("name", PRESETS)
def test_class_names_of_presets_are_in_their_lists(name: str) -> None:
    preset = PRESETS[name]
    if preset.vocabulary == "truth":
        return
    table = ClassTable.of(preset.vocabulary, {})
    lists = (preset.instance_classes, preset.retrieval_classes, preset.stuff, *preset.class_lists.values())
    assert [n for classes in lists for n in classes if not table.number(n)] == []


@pytest.mark.parametrize(
    ("wanted", "listed", "expected"),
    [
        ("couch", "nyu40", "sofa"),
        ("armchair", "nyu40", "chair"),
        ("refrigerator", "scannet20", "refridgerator"),
        ("TV", "nyu40", "television"),
        ("Coffee_Table", "scannet200", "coffee table"),
        ("sofa", "scannet200", "couch"),
        ("monitor", "scannet20", None),
        ("wall-plug", "scannet200", None),
    ],
)
def test_names_find_their_class_in_another_list(wanted: str, listed: str, expected: str | None) -> None:
    table = ClassTable.of(listed, {})
    assert table.names.get(table.number(wanted)) == expected


def test_a_narrow_class_does_not_take_its_neighbours() -> None:
    # Both are "otherprop" for NYU40, which is no reason to take one for the other.
    table = ClassTable.of("truth", {1: "cup", 2: "office chair", 3: "Sofa", 0: "unlabelled"})
    assert [table.number(name) for name in ("bottle", "armchair", "couch", "cup", "unlabelled")] == [0, 0, 3, 1, 0]
