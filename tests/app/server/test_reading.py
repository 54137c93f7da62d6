"""What the interface says of a map whose instances are known."""

from __future__ import annotations

import cv2
import numpy as np
import pytest

from app.page.packet import unpack
from tests.support.edited_maps import CHAIR, FLOOR, LAMP, NAMES, OTHER_CHAIR, TABLE, WALL, hand_made
from tests.support.gltf import read_glb
from tests.support.served_maps import API, problem_of


def ids(response) -> list[int]:
    return [instance["id"] for instance in response.json()["instances"]]


def test_instances_are_those_of_the_map(client):
    listed = client.get(f"{API}/instances").json()
    assert (listed["format"], listed["epoch"], listed["total"]) == (1, 0, len(NAMES))
    assert {entry["id"]: entry["name"] for entry in listed["instances"]} == NAMES
    boxes = {item.id: item.box for item in hand_made().objects}
    for entry in listed["instances"]:
        assert entry["center_m"] == pytest.approx(boxes[entry["id"]].center, abs=1e-3)
        assert entry["extent_m"] == pytest.approx(boxes[entry["id"]].extent, abs=1e-3)
        assert entry["kind"] == ("stuff" if entry["name"] in ("floor", "wall") else "thing")
        assert entry["probability"] > 0.9


@pytest.mark.parametrize(
    ("filters", "expected"),
    [
        ("class=chair", [CHAIR, OTHER_CHAIR]),
        ("class=CHAIR", [CHAIR, OTHER_CHAIR]),
        ("kind=stuff", [FLOOR, WALL]),
        ("min_score=0.69", [LAMP, FLOOR, WALL]),
        ("min_extent_m=1.5", [FLOOR, WALL]),
        ("text=AMP", [LAMP]),
        ("text=%234", [LAMP]),
        ("kind=thing&text=a&limit=2", [TABLE, CHAIR]),
        ("kind=thing&offset=3", [LAMP]),
        ("offset=100", []),
    ],
)
def test_instances_are_filtered_and_paged(client, filters, expected):
    assert ids(client.get(f"{API}/instances?{filters}")) == expected


def test_the_total_counts_what_is_on_other_pages(client):
    page = client.get(f"{API}/instances?kind=thing&limit=1&offset=1").json()
    assert (page["total"], len(page["instances"])) == (4, 1)


def test_one_instance_has_its_relations(client):
    chair = client.get(f"{API}/instances/{CHAIR}").json()
    assert chair["id"] == CHAIR
    assert {"relation": "on", "other": FLOOR, "other_name": "floor"} in chair["relations"]


def test_relations_and_scene_graph_agree(client):
    relations = client.get(f"{API}/relations").json()["relations"]
    assert {"subject": TABLE, "relation": "on", "object": FLOOR} in relations
    graph = client.get(f"{API}/scene_graph").json()
    assert {node["class"] for node in graph["nodes"]} == set(NAMES.values())
    assert {"from": TABLE, "to": FLOOR, "relation": "on"} in [
        {key: edge[key] for key in ("from", "to", "relation")} for edge in graph["edges"]
    ]


def test_a_text_finds_what_it_means_the_most_probable_first(client):
    answer = client.post(f"{API}/query", json={"text": "a chair"}).json()
    assert answer["found"]
    assert {hit["id"] for hit in answer["hits"]} == {CHAIR, OTHER_CHAIR}
    chances = [hit["probability"] for hit in answer["hits"]]
    assert chances == sorted(chances, reverse=True)
    assert answer["statement"] == "2 instances in this map: a chair"


def test_the_limit_is_of_hits_shown_not_of_those_counted(client):
    answer = client.post(f"{API}/query", json={"text": "chair", "limit": 1}).json()
    assert len(answer["hits"]) == 1
    assert answer["statement"] == "2 instances in this map: chair"


def test_a_lower_threshold_finds_more(client):
    everything = client.post(f"{API}/query?min_probability=0", json={"text": "chair"}).json()
    assert len(everything["hits"]) == len(NAMES)
    assert client.post(f"{API}/query?min_probability=2", json={"text": "chair"}).status_code == 422


def test_what_is_not_there_is_said_to_be_not_in_this_map(client):
    answer = client.post(f"{API}/query", json={"text": "piano"}).json()
    assert (answer["found"], answer["hits"]) == (False, [])
    assert "not in this map" in answer["statement"]


def test_mesh_names_its_nodes_and_is_sent_once(client, tmp_path):
    response = client.get(f"{API}/mesh.glb")
    (tmp_path / "mesh.glb").write_bytes(response.content)
    document = read_glb(tmp_path / "mesh.glb")[0]
    assert {node["name"] for node in document["nodes"]} >= {f"{name} {i}" for i, name in NAMES.items()}
    again = client.get(f"{API}/mesh.glb", headers={"If-None-Match": response.headers["etag"]})
    assert (again.status_code, again.content) == (304, b"")


def test_page_data_hold_the_instances(client):
    header, _ = unpack(client.get(f"{API}/page").content)
    assert {record["id"]: record["name"] for record in header["instances"]} == NAMES


def test_the_front_page_is_told_to_ask_the_server(client):
    response = client.get("/")
    assert response.headers["content-type"].startswith("text/html")
    assert '{"kind":"served"}' in response.text.replace(" ", "")
    policy = response.headers["content-security-policy"]
    assert "frame-ancestors 'none'" in policy
    assert "connect-src 'self'" in policy
    assert "unsafe-inline" not in policy


def test_a_map_without_its_recording_has_no_crops(client):
    assert client.get(f"{API}/instances/{CHAIR}").json()["crops"] == 0
    assert problem_of(client.get(f"{API}/instances/{CHAIR}/crop/0.jpg"))["status"] == 404


def test_crops_are_pictures_that_the_run_keeps(client, folder):
    kept = folder / "crops" / f"{CHAIR:04d}-{20 * CHAIR:06d}.jpg"
    kept.parent.mkdir()
    picture = cv2.imencode(".jpg", np.full((8, 8, 3), 99, np.uint8))[1].tobytes()
    kept.write_bytes(picture)
    assert client.get(f"{API}/instances/{CHAIR}").json()["crops"] == 1
    response = client.get(f"{API}/instances/{CHAIR}/crop/0.jpg")
    assert (response.headers["content-type"], response.content) == ("image/jpeg", picture)
    assert problem_of(client.get(f"{API}/instances/{CHAIR}/crop/1.jpg"))["status"] == 404


def test_a_finished_map_has_no_changes(client):
    assert "does not grow" in problem_of(client.get(f"{API}/mesh/changes?since=0"))["detail"]
