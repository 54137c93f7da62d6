"""Edits by way of the interface: they hold, they can be undone, and who comes too late is told."""

from __future__ import annotations

import json
import time

from app.editing.edit_run import edit_run
from app.served_map import shared_map
from razer.edits.edit import edit_of
from razer.saved_map import load_map
from tests.support.edited_maps import CHAIR, LAMP, OTHER_CHAIR, TABLE
from tests.support.served_maps import API, client_of, problem_of, served_map

RENAME = {"kind": "rename", "epoch": 0, "author": "Ada", "instance": CHAIR, "name": "office chair"}


def found(client, text: str) -> list[int]:
    return sorted(hit["id"] for hit in client.post(f"{API}/query", json={"text": text}).json()["hits"])


def test_an_edit_holds_for_all_who_ask_and_for_the_folder(client, folder):
    response = client.post(f"{API}/edits", json=RENAME)
    assert response.status_code == 201
    done = response.json()
    assert (done["epoch"], done["edit"]["number"], done["edit"]["author"]) == (1, 1, "Ada")
    entry = client.get(f"{API}/instances/{CHAIR}").json()
    assert (entry["name"], entry["probability"], entry["edited"], entry["epoch"]) == ("office chair", 1.0, True, 1)
    assert found(client, "office chair") == [CHAIR]
    assert {o.id: o.class_name for o in load_map(folder).objects}[CHAIR] == "office chair"


def test_a_server_started_anew_has_the_edits(client, folder):
    client.post(f"{API}/edits", json=RENAME)
    with client_of(served_map(folder)) as other:
        assert found(other, "office chair") == [CHAIR]
        assert other.get(f"{API}/edits").json()["can_undo"]


def test_undo_and_redo(client):
    client.post(f"{API}/edits", json=RENAME)
    undone = client.delete(f"{API}/edits/last").json()
    assert (undone["edit"]["kind"], undone["epoch"]) == ("undo", 2)
    assert client.get(f"{API}/instances/{CHAIR}").json()["name"] == "chair"
    assert client.post(f"{API}/edits/redo").json()["edit"]["kind"] == "redo"
    assert client.get(f"{API}/instances/{CHAIR}").json()["name"] == "office chair"
    log = client.get(f"{API}/edits").json()
    assert [edit["kind"] for edit in log["edits"]] == ["rename", "undo", "redo"]
    assert (log["epoch"], log["can_undo"], log["can_redo"]) == (3, True, False)


def test_merging_splitting_and_deleting_change_what_there_is(client):
    client.post(f"{API}/edits", json={"kind": "merge", "epoch": 0, "instances": [CHAIR, OTHER_CHAIR]})
    assert found(client, "chair") == [CHAIR]
    assert client.get(f"{API}/instances/{OTHER_CHAIR}").status_code == 404
    region = {"plane": {"normal": [1, 0, 0], "offset_m": 0.5}}
    split = client.post(f"{API}/edits", json={"kind": "split", "epoch": 1, "instance": TABLE, "region": region}).json()
    new = client.get(f"{API}/instances/{split['edit']['new']}").json()
    assert new["vertices"] > 0
    client.post(f"{API}/edits", json={"kind": "delete", "epoch": 2, "instance": LAMP})
    assert "not in this map" in client.post(f"{API}/query", json={"text": "lamp"}).json()["statement"]


def test_a_stale_edit_is_refused_with_the_reason_and_changes_nothing(client):
    client.post(f"{API}/edits", json=RENAME)
    late = client.post(f"{API}/edits", json={**RENAME, "author": "Bob", "name": "stool"})
    problem = problem_of(late)
    assert (problem["status"], problem["type"]) == (409, "stale")
    assert "office chair" in problem["detail"]
    assert client.get(f"{API}/edits").json()["epoch"] == 1


def test_an_old_epoch_is_no_matter_where_nobody_touched_the_instance(client):
    client.post(f"{API}/edits", json=RENAME)
    other = client.post(f"{API}/edits", json={**RENAME, "instance": LAMP, "name": "torch"})
    assert (other.status_code, other.json()["epoch"]) == (201, 2)


def test_what_another_program_edits_is_seen(client, folder):
    assert found(client, "chair") == [CHAIR, OTHER_CHAIR]
    edit_run(folder, edit_of({"kind": "rename", "instance": CHAIR, "name": "throne"}), "Bob")
    assert found(client, "throne") == [CHAIR]
    assert client.get(f"{API}/instances").json()["epoch"] == 1


def test_who_was_too_late_sees_the_map_as_it_is_then(client, folder):
    client.get(f"{API}/instances")
    edit_run(folder, edit_of({"kind": "rename", "instance": CHAIR, "name": "throne"}), "Bob")
    assert problem_of(client.post(f"{API}/edits", json=RENAME))["status"] == 409
    assert client.get(f"{API}/instances/{CHAIR}").json()["epoch"] == 1
    assert client.post(f"{API}/edits", json={**RENAME, "epoch": 1}).status_code == 201


def test_a_damaged_log_leaves_the_map_that_is_open(client, folder):
    client.post(f"{API}/edits", json=RENAME)
    log = folder / "edits.jsonl"
    log.write_text("no log\n")
    assert client.get(f"{API}/instances/{CHAIR}").json()["name"] == "office chair"
    assert problem_of(client.post(f"{API}/edits", json={**RENAME, "epoch": 1}))["status"] == 422
    assert log.read_text() == "no log\n"


def test_a_map_that_was_made_anew_is_opened_anew(client, folder):
    instances = json.loads((folder / "instances.json").read_text())
    for entry in instances["instances"]:
        entry["class"] = "pouffe" if entry["id"] == CHAIR else entry["class"]
    time.sleep(0.01)
    (folder / "instances.json").write_text(json.dumps(instances))
    assert client.get(f"{API}/instances/{CHAIR}").json()["name"] == "pouffe"


def test_page_and_mesh_get_another_tag(client):
    tags = [client.get(path).headers["etag"] for path in (f"{API}/page", f"{API}/mesh.glb")]
    client.post(f"{API}/edits", json=RENAME)
    assert client.get(f"{API}/page", headers={"If-None-Match": tags[0]}).status_code == 200
    assert client.get(f"{API}/mesh.glb", headers={"If-None-Match": tags[1]}).status_code == 200


def test_the_mesh_for_other_programs_follows_once_nobody_edits_any_more(served, folder, monkeypatch):
    (folder / "mesh.glb").write_bytes(b"an older mesh")
    monkeypatch.setattr(shared_map, "CALM_S", 1000.0)
    with client_of(served) as client:
        client.post(f"{API}/edits", json=RENAME)
        served.source.tend()
        assert (folder / "mesh.glb").read_bytes() == b"an older mesh"
        monkeypatch.setattr(shared_map, "CALM_S", -1.0)
        served.source.tend()
    assert b"office chair" in (folder / "mesh.glb").read_bytes()
