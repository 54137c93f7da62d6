"""`razer eval --export`: what is written gives the same numbers again, bit by bit, and by the benchmark's rules."""

from __future__ import annotations

import json

import numpy as np
import pytest

from data_tools.predictions.submission import read_submission
from data_tools.truth.open_truth import open_truth
from data_tools.writers.scannet_truth import write_scannet_truth
from razer.metrics.presets import PRESETS
from tests.support.benchmark_rules import benchmark, listed_predictions
from tests.support.cli import call, map_oracle_room

SCENE = "scene0000_00"
FILES = {"scannet": f"{SCENE}.txt", "replica": f"{SCENE}.txt", "labels": f"{SCENE}.ply"}


@pytest.fixture(scope="module")
def mapped(tmp_path_factory):
    """A run whose confidences have all digits and one of whose instances is of no class, and a truth in ScanNet's
    layout, which has no vertices out of sight."""
    place = tmp_path_factory.mktemp("export")
    run, recording = map_oracle_room(place, 16, (128, 96))
    truth = place / SCENE
    truth.mkdir()
    write_scannet_truth(open_truth(recording), truth, SCENE)
    listed = json.loads((run / "instances.json").read_text())
    for number, entry in enumerate(listed["instances"]):
        entry["score"] = 1 / (3 + number)
    listed["instances"][0]["class"] = None
    (run / "instances.json").write_text(json.dumps(listed))
    return run, truth, recording


def evaluated(capsys, *arguments):
    assert call("eval", *arguments, "--json") == 0
    captured = capsys.readouterr()
    return json.loads(captured.out.splitlines()[-1]), captured.err


def numbers(result):
    """What must be the same: AP of all kinds, and counts."""
    return [result[key] for key in ("class_agnostic", "class_aware", "n_truth", "n_predicted", "missed", "duplicates")]


QUICK = [("default", "scannet"), ("default", "labels"), ("default", "replica"), ("scannet20", "scannet")]
SLOW = [
    ("scannet200", "scannet"),
    ("scenenn", "replica"),
    ("scenenn", "scannet"),
    ("ovo", "labels"),
    ("ovo", "replica"),
]


@pytest.mark.parametrize(
    ("preset", "wanted"), [*QUICK, *(pytest.param(*pair, marks=pytest.mark.full) for pair in SLOW)]
)
def test_an_export_gives_the_same_numbers_again(mapped, tmp_path, capsys, wanted, preset):
    run, truth, recording = mapped
    truth = recording if preset == "default" else truth  # numbers of the truth's own, and vertices out of sight
    rules = ("--truth", truth, "--preset", preset, "--set", "min_region=20")
    first, notes = evaluated(capsys, run, *rules, "--export", wanted, tmp_path / "out")
    written = FILES[wanted].replace(SCENE, truth.name)
    assert str(tmp_path / "out" / written) in notes
    again, _ = evaluated(capsys, tmp_path / "out" / written, *rules)
    assert numbers(again) == numbers(first)
    assert first["class_agnostic"]["ap50"] > 0.1


@pytest.mark.parametrize("preset", ["scannet20", pytest.param("scannet200", marks=pytest.mark.full)])
def test_the_benchmarks_own_rules_find_the_same_in_what_is_written(mapped, tmp_path, capsys, preset):
    run, truth, _ = mapped
    result, _ = evaluated(capsys, run, "--truth", truth, "--preset", preset, "--export", "scannet", tmp_path)
    scene = open_truth(truth, vocabulary=preset)
    labels = [n for n, name in scene.class_names.items() if name not in PRESETS[preset].instance_ignored]
    ids = np.where(scene.classes > 0, scene.classes.astype(np.int64) * 1000 + scene.instances, 0)
    by_script = benchmark([(ids, listed_predictions(tmp_path / f"{SCENE}.txt", labels))], labels)
    ours = result["class_aware"]["per_class"]
    some = {scene.class_names[label]: aps for label, aps in by_script.items() if not np.isnan(aps).any()}
    assert len(some) > 2
    for name, aps in some.items():
        expected = [np.mean(aps[:9]), aps[0], aps[9]]
        assert [ours[name][key] for key in ("ap", "ap50", "ap25")] == pytest.approx(expected, abs=1e-12)
    assert {path.name for path in tmp_path.glob("*.txt")} == {f"{SCENE}.txt"}  # the script takes each for a scene


def test_a_submission_is_exported_as_it_is_and_overlaps_fit_no_labels(mapped, tmp_path, capsys):
    run, truth, _ = mapped
    rules = ("--truth", truth, "--preset", "scannet200")
    evaluated(capsys, run, *rules, "--export", "scannet", tmp_path / "a")
    evaluated(capsys, tmp_path / "a", *rules, "--export", "scannet", tmp_path / "b")
    one, other = (read_submission(tmp_path / name / f"{SCENE}.txt") for name in "ab")
    assert (one.labels, one.scores) == (other.labels, other.scores)
    assert all((one.masks[i] == other.masks[i]).all() for i in one.masks)
    listed = tmp_path / "a" / f"{SCENE}.txt"
    listed.write_text(listed.read_text() + listed.read_text().splitlines()[0] + "\n")
    assert call("eval", listed, *rules, "--export", "labels", tmp_path / "c") == 2
    assert "overlap" in capsys.readouterr().err
    assert not (tmp_path / "c").exists()


def test_a_map_of_nothing_is_an_empty_list(mapped, tmp_path, capsys):
    _, truth, _ = mapped
    rules = ("--truth", truth, "--preset", "scannet200")
    (tmp_path / "nothing.txt").write_text("")
    result, _ = evaluated(capsys, tmp_path / "nothing.txt", *rules, "--export", "scannet", tmp_path / "out")
    assert (tmp_path / "out" / f"{SCENE}.txt").read_text() == ""
    again, _ = evaluated(capsys, tmp_path / "out", *rules)
    assert numbers(again) == numbers(result)
    assert again["class_agnostic"]["ap50"] == 0.0
