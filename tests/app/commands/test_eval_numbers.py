"""Class numbers of predictions: read by the preset's whole list, whatever classes the truth of a scene has."""

from __future__ import annotations

import json

import numpy as np
import pytest

from data_tools.predictions.mask_file import mask_text
from data_tools.truth.ground_truth import GroundTruth
from data_tools.truth.truth_folder import write_truth
from data_tools.writers.scannet_truth import write_scannet_truth
from razer.metrics.presets import PRESETS
from razer.vocabulary import vocabulary
from tests.support.benchmark_rules import benchmark, listed_predictions
from tests.support.cli import call

SCENE = "scene0000_00"
DOOR, CHAIR, BLINDS = 8, 5, 13  # of NYU40; 5 is the door of ScanNet200
THING = np.repeat([1, 2, 3, 4], [200, 200, 150, 150])  # a door, a cup, a wall, and what is nobody's
SCANNET20 = [category.id for category in vocabulary("scannet20").categories if not category.stuff]


def hand_made(numbers):
    """A truth of 700 vertices on a line; `numbers` are the classes of door, cup and wall."""
    points = np.stack([np.arange(700) * 0.01, *np.zeros((2, 700))], axis=1).astype(np.float32)
    classes = np.array([0, *numbers, 0], np.int32)[THING]
    names = dict(zip(numbers, ("door", "cup", "wall"), strict=True))
    triangles = np.array([[0, 1, 2]], np.int32)
    return GroundTruth(
        points, triangles, np.where(THING < 4, THING, 0).astype(np.int32), classes, names, points[:, 1] == 0
    )


@pytest.fixture
def scannet(tmp_path):
    write_scannet_truth(hand_made((5, 2, 1)), made(tmp_path / SCENE), SCENE)
    return tmp_path / SCENE


def made(folder):
    folder.mkdir(parents=True)
    return folder


def submission(folder, *predictions):
    """A submission of (things in the mask, class number, confidence)."""
    (folder / "predicted_masks").mkdir(parents=True)
    lines = []
    for number, (things, label, confidence) in enumerate(predictions):
        (folder / f"predicted_masks/{number}.txt").write_bytes(mask_text(np.isin(THING, things)))
        lines.append(f"predicted_masks/{number}.txt {label} {confidence}\n")
    (folder / f"{SCENE}.txt").write_text("".join(lines))
    return folder


def evaluated(capsys, *arguments):
    assert call("eval", *arguments, "--json") == 0
    return json.loads(capsys.readouterr().out.splitlines()[-1])


@pytest.mark.parametrize("preset", ["scannet20", "scenenn", "retrieval"])
def test_a_perfect_door_stays_perfect_whatever_else_is_a_chair(scannet, tmp_path, capsys, preset):
    # The surer one is a chair where the cup is. No chair is true here, and 5 is the door among ScanNet200's numbers.
    folder = submission(tmp_path / "s", ([1], DOOR, 0.5), ([2], CHAIR, 0.9))
    result = evaluated(capsys, folder, "--truth", scannet, "--preset", preset)["class_aware"]
    assert result["per_class"]["door"] == {"ap": 1.0, "ap50": 1.0, "ap25": 1.0}
    ids = THING + np.array([0, DOOR, 40, 1, 0])[THING] * 1000
    by_script = benchmark([(ids, listed_predictions(folder / f"{SCENE}.txt", SCANNET20))], SCANNET20)
    assert by_script[DOOR] == [1.0] * 10


def test_the_same_numbers_among_scannet200s_are_two_doors(scannet, tmp_path, capsys):
    folder = submission(tmp_path / "s", ([1], 5, 0.5), ([2], 5, 0.9))
    result = evaluated(capsys, folder, "--truth", scannet, "--preset", "scannet200")["class_aware"]
    assert result["per_class"]["door"]["ap"] == 0.25  # points (1/2, 1), (0, 0) and (1, 0)


def test_scannet20_evaluates_eighteen_classes_and_leaves_out_what_the_script_does(scannet, tmp_path, capsys):
    alone = submission(tmp_path / "a", ([1], DOOR, 0.5))
    more = submission(tmp_path / "b", ([1], DOOR, 0.5), ([1, 2], BLINDS, 0.9), ([3], 1, 0.8), ([1], 0, 0.7))
    first, second = (evaluated(capsys, s, "--truth", scannet, "--preset", "scannet20") for s in (alone, more))
    assert second["class_aware"] == first["class_aware"]
    assert len(SCANNET20) == 18
    assert SCANNET20 == [3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 14, 16, 24, 28, 33, 34, 36, 39]
    assert PRESETS["scannet20"].thresholds == PRESETS["scannet200"].thresholds


@pytest.mark.parametrize(("preset", "number"), [("scannet20", 41), ("scannet200", 12), ("default", 12)])
def test_unknown_numbers_are_named(scannet, tmp_path, capsys, preset, number):
    folder = submission(tmp_path / "s", ([1], 5, 0.5), ([2], number, 0.9), ([2], -3, 0.9))
    assert call("eval", folder, "--truth", scannet, "--preset", preset) == 2
    error = capsys.readouterr().err
    assert f"class numbers -3, {number}, which are not among those of" in error
    assert f"{SCENE}.txt" in error
    labels = tmp_path / "labels.txt"
    np.savetxt(labels, np.where(THING == 1, number * 1000 + 1, 0), fmt="%d")
    assert call("eval", labels, "--truth", scannet, "--preset", preset) == 2
    assert f"class numbers {number}, which" in capsys.readouterr().err


def test_labels_of_vertices_are_numbered_as_the_preset_says(scannet, tmp_path, capsys):
    # A door, and a chair of NYU40 on the cup: ScanNet200's numbers would make that another door.
    np.savetxt(tmp_path / "labels.txt", np.array([0, 8001, 5002, 0, 0])[THING], fmt="%d")
    result = evaluated(capsys, tmp_path / "labels.txt", "--truth", scannet, "--preset", "scannet20")
    assert result["class_aware"]["per_class"]["door"]["ap"] == 1.0
    assert "door" not in {one["predicted_class"] for one in result["worst"] if one["truth"] == 2}


def test_a_truth_of_its_own_names_means_its_own_numbers(tmp_path, capsys):
    write_truth(hand_made((1, 2, 3)), tmp_path / "truth")
    own = submission(tmp_path / "s", ([1], 1, 0.5), ([2], 2, 0.9))
    result = evaluated(capsys, own, "--truth", tmp_path)["class_aware"]
    assert {name: numbers["ap"] for name, numbers in result["per_class"].items()} == {"cup": 1.0, "door": 1.0}
    strange = submission(tmp_path / "t", ([1], 8, 0.5))
    assert call("eval", strange, "--truth", tmp_path) == 2
    assert "8, which are not among those of the truth's own classes" in capsys.readouterr().err
    # With a preset's list the numbers are the list's, and only the names of the truth count.
    assert evaluated(capsys, strange, "--truth", tmp_path, "--preset", "scannet20")["class_aware"]["ap"] == 1.0


def test_a_scannet_truth_under_its_own_names_has_all_of_scannet200s_numbers(scannet, tmp_path, capsys):
    # 6 is the couch of ScanNet200, of which this scene has none.
    folder = submission(tmp_path / "s", ([1], 5, 0.5), ([2], 6, 0.9))
    assert evaluated(capsys, folder, "--truth", scannet)["class_aware"]["per_class"]["door"]["ap"] == 1.0
