"""`razer query` from the outside: the contract, the files, and how it refuses."""

from __future__ import annotations

import json

import cv2
import numpy as np
import pytest

import razer as razer_package
from data_tools.synthetic.synthetic_room import SyntheticRoom
from tests.support.cli import QUICK, ROOM_FRAMES, ROOM_SIZE, contents, instances_of, razer


def test_the_json_of_a_query_is_the_contract(capsys, run):
    code, out, _ = razer(capsys, "query", run, "a chair", "-k", 3, "--json")
    answer = json.loads(out)
    assert code == 0
    assert set(answer) == {"query", "found", "threshold", "hits"}
    assert (answer["query"], answer["found"]) == ("a chair", True)
    assert 0 < len(answer["hits"]) <= 3
    known = {entry["id"]: entry for entry in instances_of(run)}
    for hit in answer["hits"]:
        assert set(hit) == {
            "id", "score", "class", "part_of", "through", "kind", "runner_up", "runner_up_score",
            "center", "extent", "rotation", "best_frames",
        }  # fmt: skip
        assert (hit["runner_up"] is None) == (hit["runner_up_score"] is None)
        assert hit["through"] is hit["kind"] is None
        assert hit["class"] == known[hit["id"]]["class"] == "chair"
        assert answer["threshold"] <= hit["score"] <= 1
        assert [hit[part] for part in ("center", "extent", "rotation")] == [
            known[hit["id"]][part] for part in ("center", "extent", "rotation")
        ]
    scores = [hit["score"] for hit in answer["hits"]]
    assert scores == sorted(scores, reverse=True)


@pytest.mark.parametrize(
    ("text", "kind", "classes"),
    [
        ("something to sit on", "seat", {"chair", "couch", "armchair"}),
        ("furniture", "furniture", {"chair", "couch", "armchair", "table", "shelf", "cabinet"}),
        ("dishes", "dishes", {"bowl"}),
        ("electronics", "electronics", {"monitor"}),
    ],
)
def test_a_kind_finds_all_that_belongs_to_it_and_nothing_else(capsys, run, text, kind, classes):
    code, out, _ = razer(capsys, "query", run, text, "--json")
    hits = json.loads(out)["hits"]
    assert code == 0
    assert {hit["id"] for hit in hits} == {e["id"] for e in instances_of(run) if e["class"] in classes}
    assert {hit["class"] for hit in hits} == classes
    assert all(hit["through"] == hit["class"] and hit["kind"] == kind for hit in hits)
    found = razer_package.load_map(run).query(text)
    assert [(hit.object.id, hit.through, hit.kind) for hit in found.hits] == [
        (hit["id"], hit["through"], hit["kind"]) for hit in hits
    ]


def test_the_table_says_through_which_name_a_kind_was_found(capsys, run):
    _, out, _ = razer(capsys, "query", run, "something to sit on")
    assert out.count("chair, as seat") == len([e for e in instances_of(run) if e["class"] in ("chair", "armchair")])
    assert out.count("couch, as seat") == 1
    assert "found as" not in razer(capsys, "query", run, "couch")[1]
    _, out, _ = razer(capsys, "query", run, "books and couches", "--json")
    assert {(hit["through"], hit["kind"]) for hit in json.loads(out)["hits"]} == {("book", None), ("couch", None)}


def test_the_number_of_hits_is_limited_as_asked(capsys, run):
    def n_hits(*arguments):
        return len(json.loads(razer(capsys, "query", run, *arguments, "--json")[1])["hits"])

    assert n_hits("something to sit on") > 5
    assert n_hits("something to sit on", "-k", 2) == 2
    assert n_hits("chair") == n_hits("helicopter", "--min-score", 0) == 5
    assert "not in this map" in razer(capsys, "query", run, "something to eat")[1]


def test_best_frames_show_the_instance(capsys, run, made):
    _, out, _ = razer(capsys, "query", run, "couch", "--json")
    (hit,) = json.loads(out)["hits"]
    stamps = np.loadtxt(made[1] / "stamps.txt")
    room = SyntheticRoom(0, ROOM_FRAMES, *ROOM_SIZE)
    couch = next(i for i, name in room[0].instance_classes.items() if name == "couch")
    assert 1 <= len(hit["best_frames"]) <= 3
    for shown in hit["best_frames"]:
        assert set(shown) == {"frame", "stamp", "box", "crop"}
        assert shown["stamp"] == pytest.approx(stamps[shown["frame"]])
        x, y, width, height = shown["box"]
        is_couch = room[shown["frame"]].instance_ids == couch
        assert is_couch[y : y + height, x : x + width].sum() >= 0.8 * is_couch.sum() > 0
        crop = cv2.imread(shown["crop"])
        assert crop.shape[0] >= height
        assert crop.shape[1] >= width


def test_without_the_recording_there_are_no_crops_and_a_note(capsys, run):
    config = run / "config.toml"
    lines = config.read_text().splitlines()
    config.write_text("\n".join('folder = "/nowhere"' if line.startswith("folder =") else line for line in lines))
    code, out, err = razer(capsys, "query", run, "couch", "--json")
    assert code == 0
    assert [frame["crop"] for frame in json.loads(out)["hits"][0]["best_frames"]].count(None) >= 1
    assert "no crops but those that are there: the recording /nowhere is not there any more" in err
    assert not (run / "crops").exists()


def test_a_run_of_an_older_version_is_opened(capsys, run):
    config = run / "config.toml"
    head, _, rest = config.read_text().partition("[reintegration]\n")
    config.write_text(f"{head}[follow]\nevery = 2\n\n{rest[rest.index('[') :]}")
    code, out, err = razer(capsys, "query", run, "couch", "--json")
    assert code == 0, err
    assert json.loads(out)["found"] is True


def test_what_is_not_there_is_said_to_be_not_there(capsys, run):
    code, out, _ = razer(capsys, "query", run, "helicopter", "--json")
    assert code == 0
    assert json.loads(out)["found"] is False
    assert json.loads(out)["hits"] == []
    assert "not in this map" in razer(capsys, "query", run, "helicopter")[1]
    everything = json.loads(razer(capsys, "query", run, "helicopter", "--min-score", 0, "-k", 99, "--json")[1])
    assert len(everything["hits"]) == len(instances_of(run))


def test_the_table_names_hits(capsys, run):
    _, out, _ = razer(capsys, "query", run, "couch")
    assert "couch" in out
    assert "not in this map" not in out


def test_the_picture_has_the_hits_in_colour(capsys, run, tmp_path):
    shown, none = tmp_path / "hit.png", tmp_path / "none.png"
    razer(capsys, "query", run, "couch", "--render", shown)
    razer(capsys, "query", run, "helicopter", "--render", none)

    def coloured(path):
        picture = cv2.imread(str(path)).astype(int)
        return int((picture.max(axis=2) - picture.min(axis=2) > 60).sum())

    assert coloured(shown) > 500
    assert coloured(none) == 0


def test_a_query_draws_its_answer_by_itself_unless_a_program_asks(capsys, run):
    code, out, _ = razer(capsys, "query", run, "couch", "--json", "--angle", "top")
    assert code == 0
    assert len(out.splitlines()) == 1
    razer(capsys, "query", run, "helicopter")
    assert not (run / "query.png").exists()
    _, out, _ = razer(capsys, "query", run, "couch", "--size", "400x300")
    assert f"picture: {run / 'query.png'}" in out.replace("\n", "")
    assert cv2.imread(str(run / "query.png")).shape == (300, 400, 3)


def test_a_picture_beside_json_leaves_it_one_line(capsys, run, tmp_path):
    _, out, err = razer(capsys, "query", run, "couch", "--json", "--render", tmp_path / "hit.png")
    assert json.loads(out)["hits"]
    assert "picture: " in err
    assert (tmp_path / "hit.png").exists()


def test_a_picture_finds_what_looks_alike(capsys, made, tmp_path):
    out = tmp_path / "run"
    models = ("--segmenter", "oracle", "--embedder", "appearance")
    razer(capsys, "run", made[1], "-o", out, *models, *QUICK, "--no-timeline")
    frame = SyntheticRoom(0, ROOM_FRAMES, *ROOM_SIZE)
    couch = next(i for i, name in frame[0].instance_classes.items() if name == "couch")
    best = max(range(ROOM_FRAMES), key=lambda i: (frame[i].instance_ids == couch).sum())
    rows, columns = np.nonzero(frame[best].instance_ids == couch)
    x, y = int(np.quantile(columns, 0.2)), int(np.quantile(rows, 0.2))
    width, height = int(np.quantile(columns, 0.8)) - x, int(np.quantile(rows, 0.8)) - y
    cv2.imwrite(str(tmp_path / "crop.png"), frame[best].rgb[..., ::-1])
    box = f"{x},{y},{width},{height}"
    code, text, _ = razer(
        capsys, "query", out, "--image", tmp_path / "crop.png", "--box", box, "--min-score", 0, "--json"
    )
    assert code == 0
    assert json.loads(text)["hits"][0]["class"] == "couch"
    code, _, err = razer(capsys, "query", out, "couch")
    assert code == 2
    assert "no text encoder" in err


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (("query", "RUN"), "give either a text"),
        (("query", "RUN", "chair", "--image", "BAD"), "give either a text"),
        (("query", "RUN", " "), "empty text"),
        (("query", "RUN", "chair", "-k", "0"), "-k is at least 1"),
        (("query", "RUN", "chair", "--min-score", "2"), "--min-score from 0 to 1"),
        (("query", "RUN", "chair", "--box", "1,2,3,4"), "--image"),
        (("query", "NONE", "chair"), "is no run folder"),
        (("query", "RUN", "--image", "BAD"), "no image encoder"),
        (("query", "RUN", "--image", "BAD", "--embedder", "appearance"), "is no image"),
        (("query", "RUN", "--image", "NONE", "--embedder", "appearance"), "cannot be read"),
        (("query", "RUN", "--image", "GOOD", "--box", "1,2,3", "--embedder", "appearance"), "x,y,width,height"),
        (("query", "RUN", "--image", "GOOD", "--box", "0,0,50,9", "--embedder", "appearance"), "does not lie in"),
        (("query", "RUN", "--image", "GOOD", "--embedder", "appearance"), "vectors of"),
        (("query", "RUN", "chair", "--embedder", "appearance"), "no text encoder"),
        (("query", "RUN", "chair", "--embedder", "nonsense"), "unknown embedder"),
        (("query", "RUN", "chair", "--set", "embedder.options.dimension=32"), "vectors of 32 numbers"),
        (("query", "RUN", "chair", "--render", "NONE/x/y.png"), "cannot be written"),
        (("query", "RUN", "chair", "--render", "OUT.xyz"), "cannot be written"),
    ],
)
def test_bad_input_is_one_plain_line_and_the_run_is_untouched(capsys, run, tmp_path, arguments, message):
    (tmp_path / "bad").write_bytes(b"\xff\xfe no picture, no text")
    cv2.imwrite(str(tmp_path / "good.png"), np.full((20, 30, 3), 90, np.uint8))
    places = {"RUN": "run", "NONE": "none", "BAD": "bad", "GOOD": "good.png", "OUT": "out"}
    filled = [
        next((str(tmp_path / name) + a.removeprefix(key) for key, name in places.items() if a.startswith(key)), a)
        for a in arguments
    ]
    before = contents(run)
    code, out, err = razer(capsys, *filled)
    assert (code, out) == (2, "")
    (line,) = [line for line in err.splitlines() if not line.startswith("note:")]
    assert line.startswith("razer: ")
    assert message in line
    assert {name: data for name, data in contents(run).items() if name in before} == before
    assert not (run / "panoptic.ply").exists()
