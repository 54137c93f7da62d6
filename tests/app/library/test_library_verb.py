"""`razer library` as a user has it: maps are added, asked, listed and removed."""

from __future__ import annotations

import json

import cv2
import numpy as np
import pytest

from tests.support.cli import razer
from tests.support.edited_maps import CHAIR, OTHER_CHAIR
from tests.support.libraries import WORDS, made_map, saved_run
from tests.support.served_maps import saved_map

TRUST = "--trust-plugins"


@pytest.fixture
def run(tmp_path):
    return saved_map(tmp_path / "office")


@pytest.fixture
def library(tmp_path):
    return tmp_path / "maps.lance"


def asked(capsys, *arguments):
    code, out, err = razer(capsys, "library", *arguments, "--json")
    assert code == 0, err
    return json.loads(out)


def refused(capsys, *arguments):
    code, out, err = razer(capsys, "library", *arguments)
    assert (code, out) == (2, "")
    assert err.startswith("razer: ")
    assert err.count("\n") == 1
    return err


def test_maps_are_added_asked_and_removed(capsys, run, library):
    added = asked(capsys, "add", run, "--library", library, "--scene", "floor 3")["added"]
    assert [(each["run"], each["scene"], each["n_instances"]) for each in added] == [(str(run), "floor 3", 6)]
    answer = asked(capsys, "query", "chair", "--library", library)
    assert answer.keys() == {"format", "query", "found", "threshold", "asked", "hits"}
    assert {(hit["run"], hit["scene"], hit["id"]) for hit in answer["hits"]} == {
        (str(run), "floor 3", CHAIR), (str(run), "floor 3", OTHER_CHAIR),
    }  # fmt: skip
    (listed,) = asked(capsys, "list", "--library", library)["maps"]
    assert (listed["run"], listed["instances"], listed["embedder"]) == (str(run), 6, "oracle")
    (table,) = asked(capsys, "stats", "--library", library)["tables"]
    assert (table["maps"], table["instances"], table["indexed"]) == (1, 6, False)
    assert asked(capsys, "remove", run, "--library", library)["removed"] == [str(run)]
    assert asked(capsys, "query", "chair", "--library", library)["hits"] == []
    assert asked(capsys, "compact", "--library", library)["tables"][0]["instances"] == 0


def test_a_run_that_was_edited_or_moved_since_is_said_to_be(capsys, run, library):
    def state():
        (listed,) = asked(capsys, "list", "--library", library)["maps"]
        return listed["state"]

    asked(capsys, "add", run, "--library", library)
    assert state() == "as added"
    assert razer(capsys, "edit", run, "rename", CHAIR, "throne")[0] == 0
    assert state() == "changed since"
    assert "add them again" in razer(capsys, "library", "list", "--library", library)[2]
    asked(capsys, "add", run, "--library", library)
    assert state() == "as added"
    run.rename(run.with_name("elsewhere"))
    assert state() == "not here"


def test_what_is_in_no_map_is_said_to_be(capsys, run, library):
    razer(capsys, "library", "add", run, "--library", library)
    code, out, _ = razer(capsys, "library", "query", "piano", "--library", library)
    assert code == 0
    assert out.splitlines()[0] == "not in any of these maps: piano"
    code, out, _ = razer(capsys, "library", "query", "chair", "--library", library, "--where", "class = 'lamp'")
    assert out.splitlines()[0] == "not in any of these maps: chair"


def test_a_run_that_is_added_again_takes_its_own_place(capsys, run, library):
    for _ in range(2):
        razer(capsys, "library", "add", run, "--library", library)
    assert len(asked(capsys, "query", "chair", "--library", library)["hits"]) == 2
    assert asked(capsys, "stats", "--library", library)["tables"][0]["instances"] == 6
    assert razer(capsys, "edit", run, "delete", str(CHAIR))[0] == 0
    razer(capsys, "library", "add", run, "--library", library)
    assert [hit["id"] for hit in asked(capsys, "query", "chair", "--library", library)["hits"]] == [OTHER_CHAIR]


def test_a_run_that_is_named_twice_is_added_and_removed_once(capsys, run, library):
    twice = (run, run.parent / "." / run.name, "--library", library)
    assert len(asked(capsys, "add", *twice)["added"]) == 1
    assert asked(capsys, "remove", *twice)["removed"] == [str(run)]


def test_what_cannot_be_added_is_said_before_any_is_and_else_what_was_added_is_told(capsys, tmp_path, run, library):
    assert "no run folder" in refused(capsys, "add", run, tmp_path, "--library", library)
    assert not library.exists()
    bare = saved_run(tmp_path / "bare", made_map(1, n=0))
    code, out, err = razer(capsys, "library", "add", run, bare, "--library", library)
    assert (code, out) == (2, f"{run}: 6 instances of scene {run.name}\n")
    assert "no embeddings" in err


def test_a_library_is_where_its_name_says_and_is_made_by_add_alone(capsys, tmp_path, run, monkeypatch):
    monkeypatch.chdir(tmp_path)
    for verb in (("query", "chair"), ("list",), ("stats",), ("compact",), ("remove", run)):
        assert "is no library" in refused(capsys, *verb, "--library", "nowhere")
    assert not (tmp_path / "nowhere").exists()
    (tmp_path / "file").touch()
    assert "is a file" in refused(capsys, "add", run, "--library", "file")
    assert "names no place" in refused(capsys, "add", run, "--library", "")
    assert "names no place" in refused(capsys, "stats", "--library", "")
    message = refused(capsys, "add", run, "--library", "s3://user:hush@bucket/maps")
    assert "come from the environment" in message
    assert "hush" not in message
    for name, folder in (("~", tmp_path / "~"), (f"file://{tmp_path}/a%20b", tmp_path / "a b")):
        asked(capsys, "add", run, "--library", name)
        assert asked(capsys, "stats", "--library", folder)["bytes"] > 0


def test_a_name_given_by_hand_is_found(capsys, run, library):
    assert razer(capsys, "edit", run, "rename", str(CHAIR), "Grandma's red piano bench")[0] == 0
    razer(capsys, "library", "add", run, "--library", library)
    for text in ("grandma's red piano bench", "Grandma's red piano benches"):
        expected = json.loads(razer(capsys, "query", run, text, "--json")[1])["hits"]
        hits = asked(capsys, "query", text, "--library", library)["hits"]
        assert [(hit["id"], hit["score"]) for hit in hits] == [(hit["id"], hit["score"]) for hit in expected]
        assert CHAIR in {hit["id"] for hit in hits}


def test_filters_and_scenes(capsys, tmp_path, library):
    for name in ("a", "b"):
        razer(capsys, "library", "add", saved_map(tmp_path / name), "--library", library)
    where = f"scene = 'a' and id = {CHAIR} and height_m < 1"
    answer = asked(capsys, "query", "chair", "--library", library, "--where", where)
    assert [(hit["scene"], hit["id"]) for hit in answer["hits"]] == [("a", CHAIR)]
    assert answer["asked"] == 1
    assert asked(capsys, "query", "chair", "--library", library, "--where", "height_m > 100")["asked"] == 0
    scenes = asked(capsys, "query", "chair", "--library", library, "--by-scene")["scenes"]
    assert [(each["scene"], [hit["id"] for hit in each["hits"]]) for each in scenes] == [
        (name, [CHAIR, OTHER_CHAIR]) for name in ("a", "b")
    ]


def test_an_instance_is_asked_for_others_like_it(capsys, tmp_path, library):
    for name in ("a", "b"):
        razer(capsys, "library", "add", saved_map(tmp_path / name), "--library", library)
    answer = asked(capsys, "query", "--like", f"{tmp_path / 'a'}:{CHAIR}", "--library", library)
    assert {(hit["scene"], hit["id"]) for hit in answer["hits"]} == {
        ("a", OTHER_CHAIR), ("b", CHAIR), ("b", OTHER_CHAIR),
    }  # fmt: skip


def test_a_picture_is_asked_for(capsys, tmp_path, library):
    run = saved_run(tmp_path / "run", made_map(3))
    razer(capsys, "library", "add", run, "--library", library)
    picture = tmp_path / "word.png"
    cv2.imwrite(str(picture), np.full((8, 8, 3), WORDS.index("mug"), np.uint8))
    code, out, err = razer(capsys, "query", run, "--image", picture, "--json", TRUST)
    assert code == 0, err
    expected = json.loads(out)["hits"]
    hits = asked(capsys, "query", "--image", picture, "--library", library, TRUST)["hits"]
    assert expected
    assert [hit["id"] for hit in hits] == [hit["id"] for hit in expected]
    np.testing.assert_allclose([hit["score"] for hit in hits], [hit["score"] for hit in expected], atol=2e-3)


def test_vectors_of_several_models_are_kept_apart(capsys, tmp_path, run, library):
    other = saved_run(tmp_path / "other", made_map(1))
    razer(capsys, "library", "add", run, other, "--library", library)
    tables = [each["table"] for each in asked(capsys, "stats", "--library", library)["tables"]]
    assert len(tables) == 2
    message = refused(capsys, "query", "chair", "--library", library)
    assert all(name in message for name in ("--table", *tables))
    (oracle,) = (name for name in tables if name.startswith("oracle"))
    hits = asked(capsys, "query", "chair", "--library", library, "--table", oracle)["hits"]
    assert {hit["run"] for hit in hits} == {str(run)}


def test_a_model_from_outside_is_not_loaded_because_a_library_names_it(capsys, tmp_path, library):
    razer(capsys, "library", "add", saved_run(tmp_path / "run", made_map(1)), "--library", library)
    assert "code from outside" in refused(capsys, "query", "mug", "--library", library)


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        (("query", "chair", "--where", "colour = 'red'"), "No field named colour"),
        (("query", "chair", "--where", "class ="), "Expected"),
        (("query", "chair", "--where", "1"), "boolean"),
        (("query", "chair", "--like", "there:3"), "give one of these"),
        (("query",), "give one of these"),
        (("query", "--like", "there:3"), "no map of there"),
        (("query", "--like", "3"), "RUN:ID"),
        (("query", "chair", "--table", "clip-512"), "no table 'clip-512'"),
        (("query", "chair", "-k", "0"), "-k is at least 1"),
        (("remove", "nowhere"), "no map of nowhere"),
    ],
)
def test_what_cannot_be_is_one_plain_line(capsys, run, library, arguments, said):
    razer(capsys, "library", "add", run, "--library", library)
    assert said in refused(capsys, *arguments, "--library", library)


def test_no_library_and_no_embeddings_are_told(capsys, tmp_path, library):
    assert "is no library" in refused(capsys, "query", "chair", "--library", library)
    bare = saved_run(tmp_path / "bare", made_map(1, n=0))
    assert "no embeddings" in refused(capsys, "add", bare, "--library", library)
    assert "no run folder" in refused(capsys, "add", tmp_path, "--library", library)


def test_without_its_extra_a_library_says_so(capsys, monkeypatch, library):
    monkeypatch.setattr("app.settings.extra_libraries.find_spec", lambda name: None)
    assert "razer[library]" in refused(capsys, "list", "--library", library)
