"""`razer edit` from the outside: what it says, and that every verb that opens the map respects it."""

from __future__ import annotations

import json
import subprocess
import sys
from itertools import pairwise

import cv2
import numpy as np
import pytest

import razer as razer_package
from app.editing.edit_run import open_session
from razer.edits.edit import edit_of
from razer.edits.log import EditLog
from razer.storage.ply import read_mesh_ply
from tests.support.cli import contents, instances_of, razer
from tests.support.gltf import read_glb


def ids_of(run, name):
    entries = [entry for entry in instances_of(run) if entry["class"] == name]
    return [entry["id"] for entry in sorted(entries, key=lambda entry: -entry["n_vertices"])]


def hits(capsys, run, text):
    code, out, err = razer(capsys, "query", run, text, "--json")
    assert code == 0, err
    return {hit["id"]: (hit["class"], hit["score"]) for hit in json.loads(out)["hits"]}


def test_one_plain_line_says_what_changed_and_what_is_next(capsys, run):
    chair = ids_of(run, "chair")[0]
    code, out, err = razer(capsys, "edit", run, "rename", chair, "office chair")
    assert code == 0
    assert out.splitlines()[0] == f"edit 1: chair #{chair} was named office chair"
    assert f"next: razer edit {run} undo" in err.splitlines()
    assert razer(capsys, "edit", run, "undo")[1].startswith(f"edit 2: edit 1 was undone: chair #{chair} was named")
    _, out, _ = razer(capsys, "edit", run, "log")
    assert [line.endswith("(undone)") for line in out.splitlines()] == [True, False]
    assert razer(capsys, "edit", run, "log", "--json")[1].count("\n") == 1


def test_the_json_is_the_contract(capsys, run):
    first, second = ids_of(run, "chair")[:2]
    edit = json.loads(razer(capsys, "edit", run, "merge", f"#{first}", second, "--author", "ann", "--json")[1])
    assert set(edit) == {"format", "epoch", "edit"}
    assert (edit["format"], edit["epoch"]) == (1, 1)
    assert edit["edit"] | {"time": ""} == {
        "number": 1, "epoch": 0, "time": "", "author": "ann", "kind": "merge", "instances": [first, second],
        "undone": False,
    }  # fmt: skip
    log = json.loads(razer(capsys, "edit", run, "log", "--json")[1])
    assert set(log) == {"format", "epoch", "edits", "can_undo", "can_redo"}
    assert (log["epoch"], log["can_undo"], log["can_redo"]) == (1, True, False)
    assert log["edits"] == [edit["edit"]]


def test_a_query_finds_the_new_name_and_not_the_former(capsys, run):
    chair, *others = ids_of(run, "chair")
    razer(capsys, "edit", run, "rename", chair, "garden bench")
    assert hits(capsys, run, "a garden bench") == {chair: ("garden bench", 1.0)}
    assert hits(capsys, run, "a chair").keys() <= set(others)
    assert chair in hits(capsys, run, "something to sit on")
    found = razer_package.load_map(run).query("a garden bench")
    assert [hit.object.id for hit in found.hits] == [chair]
    razer(capsys, "edit", run, "undo")
    assert chair in hits(capsys, run, "a chair")


def test_deleted_merged_and_split_instances_are_what_queries_find(capsys, run):
    chair, other, *_ = ids_of(run, "chair")
    couch = ids_of(run, "couch")[0]
    center = next(entry["center"] for entry in instances_of(run) if entry["id"] == couch)
    razer(capsys, "edit", run, "delete", chair)
    razer(capsys, "edit", run, "split", couch, "--plane", f"-1 0 0 {-center[0]}")
    new = EditLog.read(run).entries[-1].change.new
    assert chair not in hits(capsys, run, "a chair")
    assert other in hits(capsys, run, "a chair")
    assert hits(capsys, run, "couch").keys() == {couch, new}
    razer(capsys, "edit", run, "merge", new, couch)
    assert hits(capsys, run, "couch").keys() == {new}


def test_labels_respect_edits_and_keep_what_an_undo_gives_back(capsys, run, tmp_path):
    chair, other, *_ = ids_of(run, "chair")
    (tmp_path / "names.txt").write_text("chair\ngarden bench\ntable\nshelf\ncouch\n")
    razer(capsys, "edit", run, "rename", chair, "garden bench")
    razer(capsys, "edit", run, "delete", other)
    code, out, _ = razer(capsys, "label", run, "--vocabulary", tmp_path / "names.txt", "--json")
    given = {entry["id"]: (entry["class"], entry["score"]) for entry in json.loads(out)["instances"]}
    assert code == 0
    assert given[chair] == ("garden bench", 1.0)
    assert other not in given
    table = json.loads((run / "panoptic.json").read_text())
    assert table["epoch"] == 2
    assert {s["id"]: s["class"] for s in table["segments"]}[chair] == "garden bench"
    graph = json.loads((run / "scene_graph.json").read_text())
    assert other not in {node["id"] for node in graph["nodes"]}
    assert "razer label" in razer(capsys, "edit", run, "undo")[1]
    razer(capsys, "edit", run, "undo")
    known = {o.id: o.class_name for o in razer_package.load_map(run).objects}
    assert (known[chair], known[other]) == ("chair", "chair")


@pytest.mark.full
def test_an_evaluation_is_of_the_edited_map(capsys, run, made):
    def numbers():
        _, out, _ = razer(capsys, "eval", run, "--truth", made[1], "--json")
        return json.loads(out.splitlines()[-1])

    before = numbers()
    chair, other, *_ = ids_of(run, "chair")
    razer(capsys, "edit", run, "delete", chair)
    razer(capsys, "edit", run, "rename", other, "couch")
    after = numbers()
    assert after["missed"] > before["missed"]
    assert after["class_aware"]["ap50"] < before["class_aware"]["ap50"]
    for _ in range(2):
        razer(capsys, "edit", run, "undo")
    assert numbers() == before


def test_the_mesh_for_other_programs_and_the_picture_follow(capsys, run, tmp_path):
    chair, other, *_ = ids_of(run, "chair")

    def nodes():
        document, _ = read_glb(run / "mesh.glb")
        return {node["name"] for node in document["nodes"]}

    razer(capsys, "view", run, "--picture", tmp_path / "before.png")
    untouched = {name: data for name, data in contents(run).items() if name != "mesh.glb"}
    razer(capsys, "edit", run, "rename", chair, "garden bench")
    razer(capsys, "edit", run, "merge", chair, other)
    assert f"garden bench {chair}" in nodes()
    assert not {f"chair {chair}", f"chair {other}"} & nodes()
    razer(capsys, "view", run, "--picture", tmp_path / "after.png")
    before, after = (cv2.imread(str(tmp_path / name)) for name in ("before.png", "after.png"))
    assert (before != after).any()
    # The map's own files stay as the run wrote them.
    assert {name: data for name, data in contents(run).items() if name in untouched} == untouched


def test_a_comparison_is_of_the_edited_maps(capsys, run, made, tmp_path):
    chair = ids_of(run, "chair")[0]
    razer(capsys, "edit", run, "delete", chair)
    _, out, _ = razer(capsys, "compare", made[0], run, "--json", "-o", tmp_path / "compare")
    missed = json.loads(out)["instances"]["missed"]
    assert [item["id"] for item in missed] == [chair]


def test_a_saved_copy_has_its_edits_in_it_and_no_log(capsys, run, tmp_path):
    chair, other, *_ = ids_of(run, "chair")
    razer(capsys, "edit", run, "rename", chair, "garden bench")
    razer(capsys, "edit", run, "merge", chair, other)
    edited = razer_package.load_map(run)
    edited.save(tmp_path / "copy")
    assert not (tmp_path / "copy" / "edits.jsonl").exists()
    copy = razer_package.load_map(tmp_path / "copy")
    assert [(o.id, o.class_name, o.is_edited, o.is_named_by_hand, o.n_vertices) for o in copy.objects] == [
        (o.id, o.class_name, o.is_edited, o.is_named_by_hand, o.n_vertices) for o in edited.objects
    ]
    assert [hit.object.id for hit in copy.query("garden bench").hits] == [chair]
    np.testing.assert_array_equal(copy.mesh.instances, edited.mesh.instances)
    # An edited copy saved over itself has them once, too.
    razer(capsys, "edit", tmp_path / "copy", "delete", chair)
    razer_package.load_map(tmp_path / "copy").save(tmp_path / "copy")
    assert chair not in read_mesh_ply(tmp_path / "copy" / "mesh.ply").instances
    assert razer_package.load_map(tmp_path / "copy").epoch == 0


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (("RUN", "rename", "1"), "write it as: razer edit RUN rename ID NAME"),
        (("RUN", "rename", "one", "chair"), "one is no id"),
        (("RUN", "rename", "999", "chair"), "there is no instance 999"),
        (("RUN", "rename", "999", " "), "printable"),
        (("RUN", "merge", "1"), "KEPT_ID ID ..."),
        (("RUN", "split", "1"), '--plane "nx ny nz offset_m"'),
        (("RUN", "delete", "1", "--plane", "1 0 0 0"), "write it as: razer edit RUN delete ID"),
        (("RUN", "split", "1", "--plane", "1 0 0"), "nx ny nz offset_m"),
        (("RUN", "split", "1", "--plane", "0 0 0 1"), "normal"),
        (("RUN", "undo"), "there is nothing to undo"),
        (("RUN", "undo", "3"), "write it as: razer edit RUN undo"),
        (("RUN", "log", "3"), "write it as: razer edit RUN log"),
        (("NONE", "undo"), "is no run folder"),
        (("NONE", "log"), "is no run folder"),
    ],
)
def test_bad_input_is_one_plain_line_and_the_run_is_untouched(capsys, run, tmp_path, arguments, message):
    before = contents(run)
    places = {"RUN": run, "NONE": tmp_path / "none"}
    code, out, err = razer(capsys, "edit", *(places.get(a, a) for a in arguments))
    assert (code, out) == (2, "")
    (line,) = err.splitlines()
    assert line.startswith("razer: ")
    assert message in line
    assert contents(run) == before


def test_a_mesh_file_that_lacks_the_edits_is_not_simulated(capsys, run, tmp_path):
    razer(capsys, "edit", run, "delete", ids_of(run, "chair")[0])
    code, _, err = razer(capsys, "synth", tmp_path / "out", "--mesh", run)
    assert code == 2
    assert "has hand edits" in err


RACER = """
import sys
from app.editing.edit_run import now_utc, open_session
from razer.edits.edit import edit_of
from razer.errors import EditConflict
folder, name, first, shared = sys.argv[1], sys.argv[2], int(sys.argv[3]), int(sys.argv[4])
session, refused = open_session(folder), 0
print("ready", flush=True)
sys.stdin.readline()
for turn in range(20):
    for number in (first, shared):
        edit = edit_of({"kind": "rename", "instance": number, "name": f"{name} {turn}"})
        try:
            session.apply(edit, time=now_utc(), author=name, epoch=session.epoch)
        except EditConflict:
            refused += 1
print(refused)
"""


@pytest.mark.full
def test_two_processes_that_edit_at_once_leave_one_log_and_the_late_one_is_told(run):
    one, other, shared = ids_of(run, "chair")[:3]
    racers = [
        subprocess.Popen(
            [sys.executable, "-c", RACER, run, name, str(own), str(shared)],
            stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True,
        )
        for name, own in (("ann", one), ("bob", other))
    ]  # fmt: skip
    for racer in racers:
        assert racer.stdout.readline() == "ready\n"
    for racer in racers:
        racer.stdin.write("go\n")
        racer.stdin.flush()
    refused = [int(racer.communicate(timeout=120)[0]) for racer in racers]
    log = EditLog.read(run)
    assert [entry.number for entry in log.entries] == list(range(1, log.epoch + 1))
    assert log.epoch + sum(refused) == 80
    assert sum(refused) > 0
    # Nobody was refused for what only they edit, and each entry on the shared one knew of the last before it.
    assert [sum(e.author == name and e.change.instance == own for e in log.entries) for name, own in
            (("ann", one), ("bob", other))] == [20, 20]  # fmt: skip
    on_shared = [entry for entry in log.entries if entry.change.instance == shared]
    assert all(later.epoch >= earlier.number for earlier, later in pairwise(on_shared))


@pytest.mark.full
def test_an_editor_that_is_killed_leaves_a_log_that_opens(run):
    chair = ids_of(run, "chair")[0]
    code = (
        "import sys; from app.editing.edit_run import *; from razer.edits.edit import edit_of\n"
        "s = open_session(sys.argv[1])\n"
        "for n in range(10**6):\n"
        "    s.apply(edit_of({'kind': 'rename', 'instance': int(sys.argv[2]), 'name': f'n{n}'}), time=now_utc())\n"
        "    print(n, flush=True)\n"
    )
    racer = subprocess.Popen([sys.executable, "-c", code, run, str(chair)], stdout=subprocess.PIPE, text=True)
    for _ in range(5):
        racer.stdout.readline()
    racer.kill()
    racer.wait()
    session = open_session(run)
    assert session.epoch >= 5
    session.apply(edit_of({"kind": "rename", "instance": chair, "name": "after"}), time="")
    assert razer_package.load_map(run).query("after").found
