"""`razer query` and `razer label` from the outside: the contract, the files, and how they refuse."""

from __future__ import annotations

import json
import shutil

import cv2
import numpy as np
import pytest

from app.cli import main
from data_tools.synthetic.synthetic_room import SyntheticRoom
from data_tools.writers.table import write_recording
from razer.errors import BadInput
from razer.storage.ply import read_mesh_ply
from razer.vocabulary import vocabulary
from tests.support.gltf import read_glb

N_FRAMES, SIZE = 24, (160, 120)
QUICK = ("--set", "voxels.voxel_size_m=0.05", "--device", "cpu", "--no-timeline")


def razer(capsys, *arguments):
    """Run a command in this process; returns exit code, standard output, standard error."""
    with pytest.raises(SystemExit) as stopped:
        main([str(argument) for argument in arguments])
    out, err = capsys.readouterr()
    return stopped.value.code or 0, out, err


@pytest.fixture(scope="module")
def made(tmp_path_factory):
    """(run, recording) of a small room with perfect masks."""
    place = tmp_path_factory.mktemp("room")
    room = SyntheticRoom(0, N_FRAMES, *SIZE)
    write_recording("own", room, place / "recording", truth=room.truth(0.05), lossless=True)
    out = place / "run"
    models = ("--segmenter", "oracle", "--embedder", "oracle")
    with pytest.raises(SystemExit) as stopped:
        main(["run", str(place / "recording"), "-o", str(out), *models, *QUICK])
    assert not stopped.value.code
    return out, place / "recording"


@pytest.fixture
def run(made, tmp_path):
    """A copy of the run, to be written to."""
    return shutil.copytree(made[0], tmp_path / "run")


def instances_of(folder):
    return json.loads((folder / "instances.json").read_text())["instances"]


def contents(folder):
    return {path.name: path.read_bytes() for path in folder.iterdir() if path.is_file()}


def test_the_json_of_a_query_is_the_contract(capsys, run):
    code, out, _ = razer(capsys, "query", run, "a chair", "-k", 3, "--json")
    answer = json.loads(out)
    assert code == 0
    assert set(answer) == {"query", "found", "threshold", "hits"}
    assert (answer["query"], answer["found"]) == ("a chair", True)
    assert 0 < len(answer["hits"]) <= 3
    known = {entry["id"]: entry for entry in instances_of(run)}
    for hit in answer["hits"]:
        assert set(hit) == {"id", "score", "class", "center", "extent", "rotation", "best_frames"}
        assert hit["class"] == known[hit["id"]]["class"] == "chair"
        assert answer["threshold"] <= hit["score"] <= 1
        assert [hit[part] for part in ("center", "extent", "rotation")] == [
            known[hit["id"]][part] for part in ("center", "extent", "rotation")
        ]
    scores = [hit["score"] for hit in answer["hits"]]
    assert scores == sorted(scores, reverse=True)


def test_best_frames_show_the_instance(capsys, run, made):
    _, out, _ = razer(capsys, "query", run, "couch", "--json")
    (hit,) = json.loads(out)["hits"]
    stamps = np.loadtxt(made[1] / "stamps.txt")
    room = SyntheticRoom(0, N_FRAMES, *SIZE)
    couch = next(i for i, name in room[0].instance_classes.items() if name == "couch")
    assert 1 <= len(hit["best_frames"]) <= 3
    for shown in hit["best_frames"]:
        assert set(shown) == {"frame", "stamp", "box", "crop"}
        assert shown["stamp"] == pytest.approx(stamps[shown["frame"]])
        x, y, width, height = shown["box"]
        seen = room[shown["frame"]].instance_ids == couch
        assert seen[y : y + height, x : x + width].sum() >= 0.8 * seen.sum() > 0
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
    assert "no crops: the recording /nowhere is not there any more" in err
    assert not (run / "crops").exists()


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
        right = np.split(cv2.imread(str(path)).astype(int), 2, axis=1)[1]
        return int((right.max(axis=2) - right.min(axis=2) > 60).sum())

    assert coloured(shown) > 500
    assert coloured(none) == 0


def test_a_picture_finds_what_looks_alike(capsys, made, tmp_path):
    out = tmp_path / "run"
    models = ("--segmenter", "oracle", "--embedder", "appearance")
    razer(capsys, "run", made[1], "-o", out, *models, *QUICK)
    frame = SyntheticRoom(0, N_FRAMES, *SIZE)
    couch = next(i for i, name in frame[0].instance_classes.items() if name == "couch")
    best = max(range(N_FRAMES), key=lambda i: (frame[i].instance_ids == couch).sum())
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
    assert "no text side" in err


def bad_picture(path):
    path.write_bytes(b"no picture")
    return path


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
        (("query", "RUN", "--image", "BAD"), "no image side"),
        (("query", "RUN", "--image", "BAD", "--embedder", "appearance"), "is no image"),
        (("query", "RUN", "--image", "NONE", "--embedder", "appearance"), "cannot be read"),
        (("query", "RUN", "--image", "GOOD", "--box", "1,2,3", "--embedder", "appearance"), "x,y,width,height"),
        (("query", "RUN", "--image", "GOOD", "--box", "0,0,50,9", "--embedder", "appearance"), "does not lie in"),
        (("query", "RUN", "--image", "GOOD", "--embedder", "appearance"), "vectors of"),
        (("query", "RUN", "chair", "--embedder", "appearance"), "no text side"),
        (("query", "RUN", "chair", "--embedder", "nonsense"), "unknown embedder"),
        (("query", "RUN", "chair", "--set", "embedder.options.dimension=32"), "vectors of 32 numbers"),
        (("query", "RUN", "chair", "--render", "NONE/x/y.png"), "cannot be written"),
        (("query", "RUN", "chair", "--render", "OUT.xyz"), "cannot be written"),
        (("label", "RUN", "--vocabulary", "nonsense"), "is no vocabulary"),
        (("label", "RUN", "--vocabulary", "BAD"), "is no vocabulary"),
        (("label", "RUN", "--vocabulary", "EMPTY"), "knows no name"),
        (("label", "RUN", "--vocabulary", "nyu40", "--embedder", "appearance"), "no text side"),
        (("label", "NONE", "--vocabulary", "nyu40"), "is no run folder"),
    ],
)
def test_bad_input_is_one_plain_line_and_the_run_is_untouched(capsys, run, tmp_path, arguments, message):
    (tmp_path / "bad").write_bytes(b"\xff\xfe no picture, no text")
    (tmp_path / "empty.txt").write_text("\n")
    cv2.imwrite(str(tmp_path / "good.png"), np.full((20, 30, 3), 90, np.uint8))
    places = {"RUN": "run", "NONE": "none", "BAD": "bad", "GOOD": "good.png", "EMPTY": "empty.txt", "OUT": "out"}
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


def test_labels_follow_the_contract_and_fill_the_run(capsys, run):
    before = instances_of(run)
    code, out, _ = razer(capsys, "label", run, "--vocabulary", "nyu40", "--json")
    told = json.loads(out)
    assert code == 0
    assert set(told) == {"vocabulary", "instances", "stuff"}
    assert told["vocabulary"] == "nyu40"
    names = vocabulary("nyu40").by_name
    for entry in told["instances"]:
        assert set(entry) == {"id", "class", "score", "runner_up"}
        assert entry["class"] in names
        assert entry["runner_up"] in names
        assert entry["runner_up"] != entry["class"]
        assert 0 <= entry["score"] <= 1
    given = {entry["id"]: entry["class"] for entry in told["instances"]}
    after = instances_of(run)
    assert {entry["id"]: entry["class"] for entry in after} == given
    assert [{**entry, "class": None} for entry in after] == [{**entry, "class": None} for entry in before]
    # The oracle's own names are in the vocabulary for many: those must be kept.
    kept = [entry for entry in before if entry["class"] in names]
    assert len(kept) > 5
    assert all(given[entry["id"]] == entry["class"] for entry in kept)
    walls = [entry["id"] for entry in before if entry["class"] == "wall"]
    (wall,) = [entry for entry in told["stuff"] if entry["class"] == "wall"]
    assert len(walls) > 1
    assert set(walls) <= set(wall["instances"])
    assert wall["id"] == min(wall["instances"])
    assert not list(run.glob(".part-*"))


def test_the_panoptic_mesh_and_table_agree(capsys, run):
    mesh = read_mesh_ply(run / "mesh.ply")
    razer(capsys, "label", run, "--vocabulary", "nyu40")
    table = json.loads((run / "panoptic.json").read_text())
    assert (table["format"], table["vocabulary"]) == (1, "nyu40")
    header, _, body = (run / "panoptic.ply").read_bytes().partition(b"end_header\n")
    assert b"property int instance\nproperty int class\n" in header
    fields = [("xyz", "<f4", 3), ("rgb", "u1", 3), ("instance", "<i4"), ("class", "<i4")]
    vertices = np.frombuffer(body, np.dtype(fields), len(mesh.vertices))
    np.testing.assert_array_equal(vertices["xyz"], mesh.vertices)
    for segment in table["segments"]:
        own = np.isin(mesh.instances, segment["instances"])
        np.testing.assert_array_equal(vertices["instance"] == segment["id"], own)
        assert (vertices["class"][own] == segment["class_id"]).all()
        assert segment["n_vertices"] == own.sum()
        assert segment["stuff"] or len(segment["instances"]) == 1
    assert (vertices["class"][mesh.instances == 0] == 0).all()


def test_the_scene_graph_and_the_nodes_of_the_mesh(capsys, run):
    razer(capsys, "label", run, "--vocabulary", "scannet200")
    graph = json.loads((run / "scene_graph.json").read_text())
    assert set(graph) == {"nodes", "edges"}
    nodes = {node["id"]: node for node in graph["nodes"]}
    for edge in graph["edges"]:
        assert set(edge) == {"from", "to", "relation", "distance_m"}
        assert edge["from"] != edge["to"]
        assert {edge["from"], edge["to"]} <= set(nodes)
        assert edge["relation"] in ("on", "in", "under", "next to", "against")
        assert edge["distance_m"] >= 0
    on = {(nodes[e["from"]]["class"], nodes[e["to"]]["class"]) for e in graph["edges"] if e["relation"] == "on"}
    assert ("cabinet", "floor") in on
    assert ("chair", "floor") in on
    names = {node["name"] for node in read_glb(run / "mesh.glb")[0]["nodes"]}
    segments = json.loads((run / "panoptic.json").read_text())["segments"]
    assert {f"{s['class']} {s['id']}" for s in segments if s["n_vertices"] > 50} <= names


@pytest.mark.parametrize("rows", ["1,wall\n2\n", "1,\n", "99999999999,wall\n", "one,wall\n"])
def test_a_faulty_vocabulary_is_refused(tmp_path, rows):
    path = tmp_path / "mine.csv"
    path.write_text(f"id,name\n{rows}")
    with pytest.raises(BadInput, match="with a name in each row"):
        vocabulary(str(path))


def test_a_list_saved_by_a_spreadsheet_is_read(tmp_path):
    path = tmp_path / "mine.csv"
    path.write_bytes(b"\xef\xbb\xbfid,name\r\n1,wall\r\n")
    assert vocabulary(str(path)).names == ("wall",)


def test_a_vocabulary_of_ones_own(capsys, run, tmp_path):
    (tmp_path / "mine.csv").write_text("id,name,stuff\n5,couch,0\n9,floor,1\n")
    _, out, _ = razer(capsys, "label", run, "--vocabulary", tmp_path / "mine.csv", "--json")
    told = json.loads(out)
    assert {entry["class"] for entry in told["instances"]} == {"couch", "floor"}
    assert [entry["class"] for entry in told["stuff"]] == ["floor"]
    sure = [entry for entry in told["instances"] if entry["score"] >= 0.6]
    assert 2 <= len(sure) < len(told["instances"])


def test_labelling_twice_gives_the_same(capsys, run):
    razer(capsys, "label", run, "--vocabulary", "nyu40")
    once = contents(run)
    razer(capsys, "label", run, "--vocabulary", "nyu40")
    assert contents(run) == once
