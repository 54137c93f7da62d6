"""`razer label` from the outside: the contract, the files, and how it refuses."""

from __future__ import annotations

import json

import cv2
import numpy as np
import pytest

from razer.errors import BadInput
from razer.storage.ply import read_mesh_ply
from razer.vocabulary import vocabulary
from tests.support.cli import contents, instances_of, razer
from tests.support.gltf import read_glb


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (("label", "RUN", "--vocabulary", "nonsense"), "is no vocabulary"),
        (("label", "RUN", "--vocabulary", "BAD"), "is no vocabulary"),
        (("label", "RUN", "--vocabulary", "EMPTY"), "knows no name"),
        (("label", "RUN", "--vocabulary", "nyu40", "--embedder", "appearance"), "no text encoder"),
        (("label", "NONE", "--vocabulary", "nyu40"), "is no run folder"),
    ],
)
def test_bad_input_is_one_plain_line_and_the_run_is_untouched(capsys, run, tmp_path, arguments, message):
    (tmp_path / "bad").write_bytes(b"\xff\xfe no picture, no text")
    (tmp_path / "empty.txt").write_text("\n")
    places = {"RUN": "run", "NONE": "none", "BAD": "bad", "EMPTY": "empty.txt"}
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
    result = json.loads(out)
    assert code == 0
    assert set(result) == {"vocabulary", "instances", "stuff"}
    assert result["vocabulary"] == "nyu40"
    names = vocabulary("nyu40").by_name
    for entry in result["instances"]:
        assert set(entry) == {"id", "class", "score", "runner_up", "runner_up_score"}
        assert entry["class"] in names
        assert entry["runner_up"] in names
        assert entry["runner_up"] != entry["class"]
        assert 0 <= entry["score"] <= 1
    given = {entry["id"]: entry["class"] for entry in result["instances"]}
    after = instances_of(run)
    assert {entry["id"]: entry["class"] for entry in after} == given
    assert [{**entry, "class": None} for entry in after] == [{**entry, "class": None} for entry in before]
    # The oracle's own names are in the vocabulary for many: those must be kept.
    kept = [entry for entry in before if entry["class"] in names]
    assert len(kept) > 5
    assert all(given[entry["id"]] == entry["class"] for entry in kept)
    walls = [entry["id"] for entry in before if entry["class"] == "wall"]
    (wall,) = [entry for entry in result["stuff"] if entry["class"] == "wall"]
    assert len(walls) > 1
    assert set(walls) <= set(wall["instances"])
    assert wall["id"] == min(wall["instances"])
    assert not list(run.glob(".part-*"))


def test_the_classes_are_drawn_unless_a_program_asks(capsys, run):
    razer(capsys, "label", run, "--vocabulary", "nyu40", "--json")
    assert not (run / "labels.png").exists()
    _, out, _ = razer(capsys, "label", run, "--vocabulary", "nyu40")
    assert f"picture: {run / 'labels.png'}" in out
    picture = cv2.imread(str(run / "labels.png")).astype(int)
    assert (picture.max(axis=2) - picture.min(axis=2) > 40).mean() > 0.02


def test_a_run_that_cannot_be_drawn_into_is_labelled_all_the_same(capsys, run):
    (run / "labels.png").mkdir()
    code, _, err = razer(capsys, "label", run, "--vocabulary", "nyu40")
    assert code == 0
    assert "no picture" in err


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
    result = json.loads(out)
    assert {entry["class"] for entry in result["instances"]} == {"couch", "floor"}
    assert [entry["class"] for entry in result["stuff"]] == ["floor"]
    sure = [entry for entry in result["instances"] if entry["score"] >= 0.6]
    assert 2 <= len(sure) < len(result["instances"])


def test_labelling_twice_gives_the_same(capsys, run):
    razer(capsys, "label", run, "--vocabulary", "nyu40")
    once = contents(run)
    razer(capsys, "label", run, "--vocabulary", "nyu40")
    assert contents(run) == once
