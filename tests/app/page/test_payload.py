"""What a page knows of a run, and the file that it becomes."""

from __future__ import annotations

import json
import re
from base64 import b64decode

import cv2
import numpy as np
import pytest

from app.page.display_geometry import display_geometry
from app.page.html import page_html, page_policy
from app.page.packet import unpack
from app.page.payload import growing_payload, page_payload
from app.page.write_page import write_page
from razer.errors import BadInput
from tests.support.cli import razer
from tests.support.page_maps import room_map, room_mesh, save_room


@pytest.fixture
def run(tmp_path):
    return save_room(tmp_path / "flat")


def records(header):
    return {record["id"]: record for record in header["instances"]}


def test_the_header_tells_of_all_instances_and_how_they_stand(run):
    header, _ = unpack(page_payload(run))
    found = records(header)
    assert {i: r["name"] for i, r in found.items()} == {1: "floor", 2: "table", 3: "chair", 4: "cup"}
    assert {i for i, r in found.items() if r["kind"] == "stuff"} == {1}
    assert found[2]["extent_m"] == pytest.approx([1.2, 0.8, 0.7], abs=1e-3)
    assert found[2]["n_frames"] == 9
    edges = {(e["subject"], e["relation"], e["object"]) for e in header["relations"]}
    assert {(2, "on", 1), (4, "on", 2), (3, "on", 1)} <= edges
    assert header["title"] == "flat"
    assert "furniture" in header["kinds"]["chair"]
    assert header["up"] == [0, 0, 1]


def test_guesses_are_what_was_said_with_probabilities_that_add_up(run):
    header, _ = unpack(page_payload(run))
    guesses = records(header)[3]["class_guesses"]
    assert [guess["name"] for guess in guesses] == ["chair", "stool"]
    assert sum(guess["probability"] for guess in guesses) == pytest.approx(1, abs=1e-3)
    assert records(header)[3]["probability"] == guesses[0]["probability"]


def test_the_camera_path_begins_at_zero_seconds(run):
    path = unpack(page_payload(run))[0]["camera_path"]
    assert path["stamps_s"] == [0, 0.5, 1]
    assert path["positions_m"][1] == [2.2, 1.0, 1.6]


def test_crops_that_a_run_keeps_are_in_the_page(run):
    instances = json.loads((run / "instances.json").read_text())
    view = {"frame": 7, "stamp": 0.2, "box": [1, 1, 300, 200], "pixels": 100, "whole": True}
    instances["instances"][1]["best_views"] = [view]
    (run / "instances.json").write_text(json.dumps(instances))
    (run / "crops").mkdir()
    picture = np.full((200, 300, 3), (10, 200, 30), np.uint8)
    cv2.imwrite(str(run / "crops" / "0002-000007.jpg"), picture)
    header, sections = unpack(page_payload(run))
    assert header["crops"] == {"2": [len(sections["crops"])]}
    assert records(header)[2]["crops"] == 1
    shown = cv2.imdecode(np.frombuffer(sections["crops"], np.uint8), cv2.IMREAD_COLOR)
    assert max(shown.shape) <= 208
    np.testing.assert_allclose(shown.mean(axis=(0, 1)), [10, 200, 30], atol=4)


def test_a_pair_of_runs_shows_the_second_in_the_frame_of_the_first(tmp_path):
    save_room(tmp_path / "pair" / "given")
    save_room(tmp_path / "pair" / "slam")
    (tmp_path / "pair" / "compare").mkdir()
    a_from_b = np.eye(4)
    a_from_b[:3, 3] = 10, 0, 0
    numbers = {"alignment": {"a_from_b": a_from_b.tolist()}}
    (tmp_path / "pair" / "compare" / "compare.json").write_text(json.dumps(numbers))
    header, sections = unpack(page_payload(tmp_path / "pair"))
    assert header["title"] == "given"
    shift = np.subtract(header["other"]["mesh"]["origin_m"], header["mesh"]["origin_m"])
    np.testing.assert_allclose(shift, [10, 0, 0], atol=1e-4)
    assert header["other"]["camera_path"]["positions_m"][0] == [12, 1, 1.6]
    assert sections["other_edge"] == sections["edge"]


def test_decimation_keeps_places_instances_and_occlusion():
    mesh = room_mesh()
    n_shown = len(mesh.triangles) // 4
    geometry = display_geometry(mesh, n_shown)
    shown = geometry.mesh(mesh)
    assert 0 < len(shown.triangles) <= n_shown
    assert set(shown.instances.tolist()) == {1, 2, 3, 4}
    np.testing.assert_allclose(shown.vertices.max(axis=0), mesh.vertices.max(axis=0), atol=0.05)
    assert len(geometry.occlusion) == len(shown.vertices)


def test_corners_are_darker_than_open_places():
    mesh = room_mesh()
    openness = display_geometry(mesh).occlusion
    floor = (mesh.instances == 1) & (mesh.vertices[:, 2] > 0.25)
    x, y, _ = mesh.vertices.T
    under_table = floor & (np.abs(x - 1.4) < 0.75) & (np.abs(y - 1.4) < 0.55)
    open_floor = floor & (x > 3.4) & (x < 4.0) & (y > 0.6) & (y < 2.0)
    assert openness[open_floor].min() > 245
    assert openness[under_table].mean() < 225


def test_edits_change_instances_on_the_kept_geometry():
    mesh = room_mesh()
    first = display_geometry(mesh)
    mesh.instances[mesh.instances == 4] = 2
    assert display_geometry(mesh) is first
    assert set(first.mesh(mesh).instances.tolist()) == {1, 2, 3}


def test_a_growing_map_has_no_mesh_yet():
    header, sections = unpack(growing_payload(room_map(), "walk", 3))
    assert (header["mesh"], header["growing"], header["epoch"]) == (None, True, 3)
    assert len(header["instances"]) == 4
    assert not sections


def test_the_page_is_one_file_that_holds_its_data_and_no_path_of_this_machine(run, tmp_path):
    (run / "config.toml").write_text(f'[input]\nfolder = "{tmp_path}/not there"\n')
    n_bytes = write_page(run, tmp_path / "map.html")
    text = (tmp_path / "map.html").read_text()
    assert n_bytes == (tmp_path / "map.html").stat().st_size
    data = re.search(r'id="razer-payload">([^<]*)<', text)[1]
    payload = b64decode(data)
    assert payload == page_payload(run)
    header, _ = unpack(payload)
    for where in (str(tmp_path), "/home/", "/root/", "/tmp/", "/work/"):
        assert where not in text
        assert where not in json.dumps(header)
    assert text.count("</script>") == 3
    assert not re.search(r'(src|href)="(?!data:,)', text)


def test_a_served_page_has_no_data_and_may_ask_its_server_alone():
    page = page_html("served")
    assert '<script type="application/json" id="razer-source">{"kind":"served"}</script>' in page
    assert "connect-src 'self'" in page_policy("served")
    assert "connect-src 'none'" in page_policy("inline")
    with pytest.raises(ValueError, match="payload"):
        page_html("inline")


def test_a_title_is_text():
    assert "<title>a &lt;b&gt; &amp; c" in page_html("served", title="a <b> & c")


@pytest.mark.parametrize("target", ["", "no/such/folder/map.html"])
def test_a_place_that_cannot_be_written_is_one_plain_line(run, tmp_path, target):
    with pytest.raises(BadInput, match="cannot be written"):
        write_page(run, tmp_path / target)
    assert not list(tmp_path.glob("*.html"))


def test_the_verb_says_where_the_page_is_and_how_large(run, tmp_path, capsys):
    code, out, _ = razer(capsys, "view", run, "--page", tmp_path / "map.html")
    assert code == 0
    assert "map.html: 0." in out.replace("\n", "")
    code, _, _ = razer(capsys, "view", tmp_path / "nothing", "--page", tmp_path / "other.html")
    assert code == 2
    assert not (tmp_path / "other.html").exists()
