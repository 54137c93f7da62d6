"""`razer eval` on a tiny room: the truth against itself, a run, and what cannot be evaluated."""

from __future__ import annotations

import json
import re
import shutil

import cv2
import numpy as np
import pytest

from data_tools.synthetic.synthetic_room import SyntheticRoom
from data_tools.truth.truth_folder import read_truth
from data_tools.writers.own_folder import write_folder
from razer.metrics.presets import PRESETS
from tests.support.cli import call, razer

CONTRACT = {
    "class_agnostic": {"ap", "ap50", "ap25"},
    "class_aware": {"ap", "ap50", "ap25", "per_class"},
    "semantic": {"miou", "fmiou", "macc", "pixel_accuracy"},
    "panoptic": {"pq", "sq", "rq"},
    "surface": {"accuracy_m", "completeness_m", "fscore_2cm", "fscore_5cm"},
}
ONE_NEIGHBOUR = [name for name, preset in PRESETS.items() if preset.semantic_k == 1]


@pytest.fixture(scope="module")
def room(tmp_path_factory):
    folder = tmp_path_factory.mktemp("eval") / "room"
    recording = SyntheticRoom(0, 24, 128, 96)
    write_folder(recording, folder, truth=recording.truth(spacing_m=0.03))
    return folder


@pytest.fixture(scope="module")
def run(room):
    folder = room.with_name("run")
    assert call("run", room, "-o", folder, "--segmenter", "oracle", "--embedder", "oracle") == 0
    return folder


def evaluated(capsys, *arguments):
    assert call("eval", *arguments, "--json") == 0
    return json.loads(capsys.readouterr().out.splitlines()[-1])


@pytest.mark.parametrize("preset", ONE_NEIGHBOUR)
def test_the_truth_against_itself_is_perfect(room, capsys, preset):
    result = evaluated(capsys, room / "truth" / "mesh.ply", "--truth", room, "--preset", preset)
    for part in ("class_agnostic", "class_aware"):
        # A list of classes of which the room has none leaves nothing to measure.
        values = [result[part][key] for key in ("ap", "ap50", "ap25")]
        assert values == [1.0] * 3 or values == [None] * 3
    assert result["panoptic"]["pq"] == result["panoptic"]["sq"] == result["panoptic"]["rq"] == 1.0
    assert result["semantic"]["miou"] == result["semantic"]["pixel_accuracy"] == 1.0
    assert result["surface"]["accuracy_m"] == result["surface"]["completeness_m"] == 0.0
    assert result["surface"]["fscore_2cm"] == 1.0
    assert (result["duplicates"], result["missed"]) == (0, 0)
    assert result["pose"] is None


def test_a_run_is_measured_kept_and_drawn(room, run, capsys):
    result = evaluated(capsys, run, "--truth", room)
    for part, keys in CONTRACT.items():
        assert keys <= result[part].keys()
    assert result["pose"] is None  # they are the truth's own
    assert result["class_agnostic"]["ap50"] > 0.5
    assert isinstance(result["duplicates"], int)
    kinds = ("n_matched", "duplicates", "n_parts", "n_uncounted", "n_invented")
    assert result["n_predicted"] == sum(result[kind] for kind in kinds)
    assert result["n_true"] == result["n_matched"] + result["missed"]
    assert {"pq", "sq", "rq", "n_true", "n_predicted"} <= result["panoptic"]["per_class"]["chair"].keys()
    assert 0 <= result["calibration"]["ece"] <= 1
    assert result["n_judged"] == result["n_predicted"] - result["n_uncounted"]
    assert sum(part["n"] for part in result["calibration"]["bins"]) == result["n_judged"]
    assert result["naming"]["n"] == result["n_matched"]
    assert result["naming"]["accuracy"] > 0.9
    assert result["naming"]["ece"] is None  # the run says no probabilities
    assert result["warnings"] == []
    assert sum(part["n"] for part in result["recall_by_views"]) == result["n_true"]
    assert 6 < max(part["views"][1] for part in result["recall_by_views"]) <= 24
    assert json.loads((run / "metrics.json").read_text()) == result
    assert_relations(result["relations"], json.loads((room / "truth" / "relations.json").read_text()))
    for name in ("confusion.png", "precision_recall.png", "map.png"):
        picture = cv2.imread(str(run / "eval" / name))
        assert min(picture.shape[:2]) > 300
        assert len(np.unique(picture.reshape(-1, 3), axis=0)) > 5


def assert_relations(scores, true):
    """Precision and recall by relation, of no more relations than the truth states, and most of them found."""
    by_relation = scores["by_relation"]
    assert set(by_relation) == {triple["relation"] for triple in true}
    for part in (scores, *by_relation.values()):
        assert {"precision", "recall", "ends_found", "n_true", "n_predicted", "n_right"} == part.keys() - {
            "by_relation"
        }
        assert 0 <= part["recall"] <= part["ends_found"] <= 1
        expected = part["n_right"] / part["n_predicted"] if part["n_predicted"] else None
        assert part["precision"] == pytest.approx(expected, abs=1e-4)
    assert sum(part["n_true"] for part in by_relation.values()) == scores["n_true"] <= len(true)
    assert min(scores["precision"], scores["recall"]) > 0.5


@pytest.mark.full
def test_recall_by_views_goes_by_the_frames_the_run_used(room, run, tmp_path, capsys):
    half = shutil.copytree(run, tmp_path / "half")
    lines = (run / "trajectory.txt").read_text().splitlines(keepends=True)
    (half / "trajectory.txt").write_text("".join([lines[0], *lines[1::4]]))
    fewer = evaluated(capsys, half, "--truth", room)["recall_by_views"]
    assert max(part["views"][1] for part in fewer) <= 6
    # A run of another machine that kept no camera: nobody knows what its frames show.
    (half / "camera.json").unlink()
    config = (half / "config.toml").read_text().replace(str(room), "/nowhere")
    (half / "config.toml").write_text(config)
    assert evaluated(capsys, half, "--truth", room)["recall_by_views"] is None


@pytest.mark.full
def test_names_by_text_are_those_of_the_embeddings(room, run, capsys):
    result = evaluated(capsys, run, "--truth", room, "--names", "text")
    assert result["class_aware"]["ap50"] > 0.5
    # The embeddings of another seed mean nothing, and where nothing was said no name can be right but by luck.
    other = run.with_name("other")
    shutil.copytree(run, other)
    listed = json.loads((other / "instances.json").read_text())
    for entry in listed["instances"]:
        assert entry.pop("class_votes")
    (other / "instances.json").write_text(json.dumps(listed))
    before, of_embedder = (other / "config.toml").read_text().split("[embedder]")
    assert "options = {}" in of_embedder
    (other / "config.toml").write_text(
        before + "[embedder]" + of_embedder.replace("options = {}", "options = {seed = 7}", 1)
    )
    assert evaluated(capsys, other, "--truth", room, "--names", "text")["class_aware"]["ap50"] < 0.3


@pytest.mark.full
def test_a_run_shifted_by_half_a_metre_is_found_nowhere(room, run, capsys):
    from razer.storage.ply import read_mesh_ply, write_mesh_ply

    moved = run.with_name("moved")
    shutil.copytree(run, moved)
    mesh = read_mesh_ply(run / "mesh.ply")
    mesh.vertices[:] += np.float32(0.5)
    write_mesh_ply(moved / "mesh.ply", mesh)
    assert call("eval", moved, "--truth", room, "--json") == 0
    printed = capsys.readouterr()
    result = json.loads(printed.out.splitlines()[-1])
    assert result["class_agnostic"]["ap50"] < 0.1
    assert result["surface"]["fscore_5cm"] < 0.5
    (warning,) = [line for line in printed.err.splitlines() if line.startswith("WARNING: ")]
    assert "another scene" in warning
    assert warning == f"WARNING: {result['warnings'][0]}"


def test_classes_alone_have_semantics_and_no_instances(room, tmp_path, capsys):
    classes = read_truth(room / "truth").classes
    np.savetxt(tmp_path / "classes.txt", classes, fmt="%d")
    result = evaluated(capsys, tmp_path / "classes.txt", "--truth", room, "--labels", "class")
    assert result["semantic"]["miou"] == 1.0
    assert result["class_agnostic"] is None


def test_a_table_names_rules_classes_and_the_worst(room, run, capsys):
    assert call("eval", run, "--truth", room, "--set", "min_region=20") == 0
    text = capsys.readouterr().out
    for words in ("preset default", "least 20 vertices", "AP50 by class", "chair", "matched worst", "missed"):
        assert words in text
    assert re.search(r"\d+ true, \d+ predicted: \d+ matched, \d+ missed, \d+ pieces of matched ones", text)
    assert "found, by frames that show it: " in text
    assert "ATE" not in text
    assert not re.search(r"\de-\d", text)


def test_scenes_that_are_missing_are_named_and_left_out(room, run, tmp_path, capsys):
    (tmp_path / "list.txt").write_text("room\nnowhere\n")
    runs = tmp_path / "runs"
    runs.mkdir()
    (runs / "room").symlink_to(run)
    many = ("--scenes", tmp_path / "list.txt", "--runs", runs, "--truth", room.parent)
    assert list(evaluated(capsys, *many)["scenes"]) == ["room"]
    assert call("eval", *many, "--strict") == 2
    assert "nowhere" in capsys.readouterr().err


def test_a_list_without_scenes_or_with_one_twice_is_refused(room, run, tmp_path, capsys):
    many = ("--scenes", tmp_path / "list.txt", "--runs", run.parent, "--truth", room.parent)
    (tmp_path / "list.txt").write_text("\n")
    assert call("eval", *many) == 2
    assert "lists no scene" in capsys.readouterr().err
    (tmp_path / "list.txt").write_text("room\nother\nroom\n")
    assert call("eval", *many) == 2
    assert capsys.readouterr().err == f"razer: {tmp_path / 'list.txt'} lists room 2 times: leave all but one out\n"


@pytest.mark.full
def test_scenes_at_once_have_their_notes_and_links_to_nowhere_harm_nothing(room, run, tmp_path, capsys):
    (tmp_path / "list.txt").write_text("one\ntwo\n")
    for name in ("one", "two"):
        edited = shutil.copytree(run, tmp_path / "runs" / name)
        rename_what_is_gone(edited)
        (edited / "preview.png").symlink_to(tmp_path / "nowhere.png")
        (tmp_path / "truth" / name).mkdir(parents=True)
        (tmp_path / "truth" / name / "truth").symlink_to(room / "truth")
    places = ("--runs", tmp_path / "runs", "--truth", tmp_path / "truth")
    code, out, err = razer(capsys, "eval", "--scenes", tmp_path / "list.txt", *places, "--json")
    assert code == 0, err
    assert list(json.loads(out.splitlines()[-1])["scenes"]) == ["one", "two"]
    alone = razer(capsys, "eval", edited, "--truth", room, "--json")[2]
    (note,) = (line.removeprefix("note: ") for line in alone.splitlines() if "is not applied" in line)
    assert {f"note: {name}: {note}" for name in ("one", "two")} <= set(err.splitlines())


def rename_what_is_gone(run):
    """An edit of an instance that the map does not have any more."""
    assert call("edit", run, "rename", "1", "throne") == 0
    first, line = (run / "edits.jsonl").read_text().splitlines()
    edit = json.loads(line) | {"map": "0" * 16}
    edit["about"]["1"]["points"] = [[99.0, 99.0, 99.0]]
    (run / "edits.jsonl").write_text(f"{first}\n{json.dumps(edit)}\n")


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (("RUN", "--truth", "EMPTY"), "holds no ground truth"),
        (("EMPTY", "--truth", "ROOM"), "no run folder"),
        (("RUN", "--truth", "ROOM", "--preset", "mine"), "choose one of"),
        (("RUN", "--truth", "ROOM", "--set", "speed=3"), "rule=value"),
        (("RUN", "--truth", "ROOM", "--set", "min_region=-1"), "min_region"),
        (("SHORT", "--truth", "ROOM"), "does not fit"),
        (("--truth", "ROOM"), "give a run"),
        (("--truth", "ROOM", "--scenes", "SHORT"), "--runs"),
    ],
)
def test_what_cannot_be_evaluated_is_one_plain_line(room, run, tmp_path, capsys, arguments, message):
    short = tmp_path / "short.txt"
    short.write_text("1\n2\n")
    empty = tmp_path / "empty"
    empty.mkdir()
    places = {"RUN": run, "ROOM": room, "EMPTY": empty, "SHORT": short}
    assert call("eval", *(places.get(argument, argument) for argument in arguments)) == 2
    error = capsys.readouterr().err
    assert message in error
    assert error.count("\n") == 1
