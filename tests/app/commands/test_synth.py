"""`razer synth` from the outside."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

from data_tools.registry import open_sequence, recognise
from data_tools.synthetic.rendered_sequence import RenderedSequence
from data_tools.synthetic.synthetic_scene import SyntheticScene
from data_tools.truth.open_truth import open_truth
from data_tools.truth.ply_writer import write_ply
from data_tools.writers.table import WRITERS
from razer.frame import Frame
from tests.support.cli import razer
from tests.support.labelled_meshes import write_room

TINY = ("--size", "64x48", "--spacing", 0.08)
READ_AS = {"own": "folder"}


def test_the_folder_holds_the_scene_and_its_truth(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    out = tmp_path / "made"
    arguments = ("--scene", "tabletop", "--seed", 3, "--frames", 4, *TINY, "--sensor", "none", "--lossless", "--json")
    code, stdout, stderr = razer(capsys, "synth", out, *arguments)
    assert code == 0
    scene = SyntheticScene("tabletop", 3, 4, 64, 48)
    (line,) = stdout.splitlines()
    told = json.loads(line)
    vertices, classes = told.pop("vertices"), told.pop("classes")
    assert told == {
        "format": 1, "out": str(out), "scene": "tabletop", "seed": 3, "layout": "own", "sensor": "none", "frames": 4,
        "written": 4, "instances": len(scene.classes),
    }  # fmt: skip
    assert "4/4 frames" in stderr
    back = open_sequence(out)
    for index in range(4):
        np.testing.assert_array_equal(back[index].rgb, scene[index].rgb)
        np.testing.assert_array_equal(back[index].instance_ids, scene[index].instance_ids)
        np.testing.assert_allclose(back[index].depth, scene[index].depth, atol=6e-4)
        np.testing.assert_allclose(back[index].pose, scene[index].pose, atol=1e-6)
        assert back[index].stamp == pytest.approx(scene[index].stamp, abs=1e-6)
    truth, expected = open_truth(out), scene.truth(0.08)
    np.testing.assert_array_equal(truth.vertices, expected.vertices)
    np.testing.assert_array_equal(truth.visible, expected.visible)
    assert truth.instance_classes == scene.classes
    assert (vertices, classes) == (len(truth.vertices), len({*scene.classes.values()}))
    assert [path.name for path in tmp_path.iterdir()] == ["made"]


@pytest.mark.parametrize("layout", WRITERS)
def test_every_layout_is_written_and_recognised(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], layout: str
) -> None:
    out = tmp_path / "scene0000_00"
    code, stdout, _ = razer(capsys, "synth", out, "--scene", "tabletop", "--frames", 2, "--layout", layout, *TINY)
    assert code == 0
    assert stdout.startswith(f"{out}: 2 frames")
    assert recognise(out) in (READ_AS.get(layout, layout), "scannet" if layout == "sens" else layout)
    assert len(open_sequence(out)) == 2


def test_errors_of_the_sensor_are_switched_one_by_one(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    images = {}
    for name, extra in {"all": (), "whole": ("--set", "edge_dropout=0"), "none": ("--sensor", "none")}.items():
        code, _, _ = razer(
            capsys, "synth", tmp_path / name, "--scene", "tabletop", "--frames", 2, *TINY, "--lossless", *extra
        )
        assert code == 0
        images[name] = open_sequence(tmp_path / name)[1]
    np.testing.assert_array_equal(images["all"].rgb, images["whole"].rgb)
    assert not np.array_equal(images["none"].rgb, images["whole"].rgb)
    lost = {name: float((image.depth == 0).mean()) for name, image in images.items()}
    assert lost["none"] < lost["whole"] < lost["all"]


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (("--scene", "attic"), "unknown scene 'attic'"),
        (("--size", "640"), "--size 640"),
        (("--frames", -2), "--frames -2: give 0 to"),
        (("--layout", "zip"), "unknown layout 'zip'"),
        (("--set", "fog=1"), "--set fog=1"),
        (("--set", "shutter=much"), "much is no number"),
        (("--spacing", 0), "--spacing 0"),
        (("--rgb-zoom", 4), "colour zoom of 4"),
        (("--extent", "60"), "--extent 60: write it in metres"),
        (("--scene", "apartment", "--extent", "60x60"), "an extent is for warehouse and corridors"),
        (("--scene", "warehouse", "--extent", "4x60"), "an extent of 12x8 to 200x200 metres"),
        (("--people", -1), "--people -1: give 0 to 20"),
        (("--people", 1, "--rgb-zoom", 0.9), "one camera"),
        (("--rgb-shift", "8"), "--rgb-shift 8: write it as X,Y"),
        (("--rgb-shift", "80,0", *TINY), "images are 64x48"),
        (("--rgb-baseline", "0,nan,0"), "colour baseline"),
    ],
)
def test_what_cannot_be_made_is_said_in_one_line(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], arguments: tuple, words: str
) -> None:
    code, stdout, stderr = razer(capsys, "synth", tmp_path / "out", *arguments)
    assert (code, stdout) == (2, "")
    assert words in stderr
    assert len(stderr.splitlines()) == 1
    assert list(tmp_path.iterdir()) == []


def test_a_walk_through_a_labelled_mesh_is_written_with_the_mesh_as_truth(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    mesh = write_room(tmp_path / "scan")
    code, stdout, stderr = razer(
        capsys, "synth", tmp_path / "made", "--mesh", mesh, "--frames", 30, "--size", "64x48", "--lossless", "--json"
    )
    assert code == 0
    told = json.loads(stdout)
    assert (told["mesh"], told["scene"], told["written"], told["instances"]) == (str(mesh), None, 30, 8)
    assert told["up"] == pytest.approx([0, 0, 1], abs=0.01)
    assert told["nearest_m"] >= 0.3
    assert "where a person can walk" in stderr
    back, truth, given = open_sequence(tmp_path / "made"), open_truth(tmp_path / "made"), open_truth(tmp_path / "scan")
    assert len(back) == 30
    assert back[3].instance_classes == given.instance_classes
    np.testing.assert_array_equal(truth.vertices, given.vertices)
    np.testing.assert_array_equal(truth.colors, given.colors)
    np.testing.assert_array_equal(truth.triangles, given.triangles)
    assert set(np.unique(truth.instances[truth.visible])) == set(range(1, 9))


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (("--mesh", "nowhere.ply"), "nowhere.ply does not exist"),
        (("--mesh", "text.ply"), "text.ply is no PLY file"),
        (("--mesh", "bare.ply"), "bare.ply has no labels: its vertices or faces need a number instance, object_id or"),
        (("--mesh", "large.ply"), "if these are millimetres, add --mesh-scale 0.001"),
        (("--mesh", "large.ply", "--mesh-scale", 0), "--mesh-scale 0"),
        (("--mesh", "large.ply", "--scene", "apartment"), "give one of them"),
        (("--mesh", "room/mesh.ply", "--up", "w"), "--up w"),
        (("--mesh", "room/mesh.ply", "--seed", -1), "seed -1"),
        (("--mesh", "room/mesh.ply", "--light", "evening"), "are for scenes"),
        (("--mesh", "room/mesh.ply", "--walls", "bare"), "are for scenes"),
    ],
)
def test_a_mesh_that_cannot_be_walked_through_is_said_in_one_line(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], arguments: tuple, words: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    room = open_truth(write_room(tmp_path / "room").parent)
    (tmp_path / "text.ply").write_text("ply? no")
    write_ply(tmp_path / "bare.ply", room.vertices, {}, room.triangles)
    write_ply(tmp_path / "large.ply", room.vertices * 1000, {"instance": room.instances}, room.triangles)
    code, stdout, stderr = razer(capsys, "synth", tmp_path / "out", *arguments)
    assert (code, stdout) == (2, "")
    assert words in stderr
    assert [line for line in stderr.splitlines() if not line.startswith("planning")] == stderr.splitlines()[-1:]
    assert not (tmp_path / "out").exists()


def test_a_colour_camera_that_does_not_fit_depth_is_planted_and_told(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    planted = ("--rgb-zoom", 0.9, "--rgb-shift", "-8,4", "--rgb-baseline", "-0.03,0,0.01")
    usual = ("--scene", "tabletop", "--frames", 2, *TINY, "--sensor", "none", "--lossless", "--json")
    told = {}
    for name, extra in {"plain": (), "planted": planted}.items():
        code, stdout, _ = razer(capsys, "synth", tmp_path / name, *usual, *extra)
        assert code == 0
        told[name] = json.loads(stdout)
    truth = json.loads((tmp_path / "planted/truth/rgbd_calibration.json").read_text())
    assert told["planted"]["rgbd_calibration"] == truth
    assert [row[3] for row in truth["color_from_depth"]] == [0.03, 0, -0.01, 1]
    assert truth["color"]["cx"] == pytest.approx(31.5 - 8)
    assert "rgbd_calibration" not in told["plain"]
    same = ("intrinsics.json", "trajectory.txt", "depth/000001.png", "ids/000001.png")
    for path in same:
        assert (tmp_path / "plain" / path).read_bytes() == (tmp_path / "planted" / path).read_bytes()
    assert (tmp_path / "plain/color/000001.png").read_bytes() != (tmp_path / "planted/color/000001.png").read_bytes()


@pytest.mark.full
def test_a_hall_has_the_size_light_and_people_asked_for(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    usual = ("--scene", "corridors", "--extent", "12x9.5", "--frames", 6, *TINY, "--sensor", "none", "--lossless")
    for name, extra in {"day": (), "evening": ("--light", "evening"), "people": ("--people", 3)}.items():
        assert razer(capsys, "synth", tmp_path / name, *usual, *extra)[0] == 0
    truth = open_truth(tmp_path / "day")
    np.testing.assert_allclose(np.ptp(truth.vertices, axis=0)[:2], (12, 9.5), atol=1e-4)
    day, evening, people = (open_sequence(tmp_path / name) for name in ("day", "evening", "people"))
    np.testing.assert_array_equal(day[2].depth, evening[2].depth)
    assert np.abs(day[2].rgb.astype(int) - evening[2].rgb).mean() > 2
    assert any((day[i].instance_ids != people[i].instance_ids).any() for i in range(6))
    assert open_truth(tmp_path / "people").instance_classes == truth.instance_classes


def test_an_existing_folder_is_left_alone(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (tmp_path / "note.txt").write_text("mine")
    code, _, stderr = razer(capsys, "synth", tmp_path, *TINY)
    assert code == 2
    assert "exists: give a new folder" in stderr
    assert [path.name for path in tmp_path.iterdir()] == ["note.txt"]


def test_an_interrupted_run_leaves_nothing(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    frame_of = RenderedSequence.__getitem__

    def interrupted(film: RenderedSequence, index: int) -> Frame:
        if index == 2:
            raise KeyboardInterrupt
        return frame_of(film, index)

    monkeypatch.setattr(RenderedSequence, "__getitem__", interrupted)
    code, stdout, stderr = razer(capsys, "synth", tmp_path / "out", "--scene", "tabletop", "--frames", 4, *TINY)
    assert (code, stdout) == (130, "")
    assert "interrupted" in stderr
    assert list(tmp_path.iterdir()) == []
