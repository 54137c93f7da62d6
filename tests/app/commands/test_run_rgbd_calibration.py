"""`razer run` on recordings whose colour camera is not the one that they declare."""

from __future__ import annotations

import io
import json
from pathlib import Path

import numpy as np
import pytest
from rich.console import Console
from scipy.spatial import cKDTree

from app.frames.cameras.color_registration import register_color
from data_tools import open_sequence
from data_tools.synthetic.camera.rgbd_misalignment import RgbdMisalignment
from data_tools.synthetic.synthetic_room import SyntheticRoom
from data_tools.writers.own_folder import write_folder
from razer.storage.ply import read_mesh_ply
from tests.support.cli import QUICK, razer
from tests.support.spoilt import Spoilt, as_is

PLANTED = RgbdMisalignment(0.93, (-8.0, 6.0), (0.05, -0.02, 0.0))
OPTIONS = (*QUICK, "--no-timeline", "--poses", "given")


@pytest.fixture(scope="module")
def folders(tmp_path_factory: pytest.TempPathFactory) -> dict[str, Path]:
    """One walk round a room, with colour as it should be and with another colour camera, and the latter's truth."""
    root = tmp_path_factory.mktemp("walks")
    for name, planted in (("right", RgbdMisalignment()), ("planted", PLANTED)):
        room = SyntheticRoom(6, 200, 320, 240, misalignment=planted)
        write_folder(Spoilt([room[index] for index in range(0, 200, 12)], as_is), root / name, lossless=True)
    (root / "true.json").write_text(json.dumps(PLANTED.calibration(room.intrinsics).to_json()))
    return {name: root / name for name in ("right", "planted", "true.json")}


def color_error(run: Path, right: Path) -> float:
    """Median distance in colour of a map's vertices from the nearest of the right one, grey levels."""
    mesh, truth = read_mesh_ply(run / "mesh.ply"), read_mesh_ply(right / "mesh.ply")
    _, nearest = cKDTree(truth.vertices).query(mesh.vertices)
    difference = mesh.colors.astype(float) - truth.colors[nearest]
    return float(np.abs(difference).mean(axis=1).mean())


@pytest.mark.full
def test_colour_is_brought_onto_depth_unless_told_not_to(
    folders: dict[str, Path], tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    code, _, _ = razer(capsys, "run", folders["right"], "-o", tmp_path / "right", *OPTIONS)
    assert code == 0
    assert not json.loads((tmp_path / "right" / "rgbd_calibration.json").read_text())["applied"]

    _, out, err = razer(capsys, "run", folders["planted"], "-o", tmp_path / "auto", *OPTIONS, "--json")
    assert err.count("corrected (--rgbd-calibration off leaves it)") == 1
    result = json.loads(out)
    assert result["rgbd_applied"]
    assert result["rgbd"]["confident"]
    assert result["rgbd"]["zoom"] == pytest.approx(0.93, abs=0.02)
    assert "register" in result["timings"]["stages"]

    code, _, err = razer(
        capsys, "run", folders["planted"], "-o", tmp_path / "off", *OPTIONS, "--rgbd-calibration", "off"
    )
    assert "corrected" not in err
    auto, off = (color_error(tmp_path / name, tmp_path / "right") for name in ("auto", "off"))
    assert auto < 0.6 * off


def test_a_file_is_used_as_it_is_and_a_run_keeps_it(
    folders: dict[str, Path], tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    choice = ("--rgbd-calibration", folders["true.json"], "--max-frames", 3)
    code, _, err = razer(capsys, "run", folders["planted"], "-o", tmp_path / "run", *OPTIONS, *choice)
    assert code == 0
    assert "corrected" not in err
    kept = json.loads((tmp_path / "run" / "rgbd_calibration.json").read_text())
    true = json.loads(folders["true.json"].read_text())
    assert (kept["applied"], kept["color"], kept["rgbd"]) == (True, true["color"], None)


@pytest.mark.parametrize(
    ("content", "message"),
    [
        (None, "cannot be read"),
        ("{}", "must be JSON with"),
        ('{"color": {"width": 64, "height": 64, "fx": 1, "fy": 1, "cx": 1, "cy": 1}, "color_from_depth": '
         '[[1,0,0,0],[0,1,0,0],[0,0,1,0],[0,0,0,1]]}', "is for colour of 64x64, but the images are 320x240"),
    ],
)  # fmt: skip
def test_an_unusable_file_is_one_line(
    content: str | None, message: str, folders: dict[str, Path], tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    path = tmp_path / "colour.json"
    if content is not None:
        path.write_text(content)
    options = (*OPTIONS, "--rgbd-calibration", path)
    code, out, err = razer(capsys, "run", folders["planted"], "-o", tmp_path / "run", *options)
    assert (code, out, err.count("\n")) == (2, "", 1)
    assert "colour.json" in err
    assert message in err
    assert not (tmp_path / "run").exists()


def test_a_declared_colour_camera_is_left_alone(folders: dict[str, Path], tmp_path: Path) -> None:
    np.savetxt(tmp_path / "same.txt", np.eye(4))
    console = Console(file=io.StringIO())
    declared = open_sequence(folders["planted"], depth_to_color=tmp_path / "same.txt")
    registration = register_color(declared, "auto", console)
    assert (registration.calibration, registration.estimate) == (None, None)
