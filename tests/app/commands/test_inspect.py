"""`razer inspect`: the facts it states, what it prints, and what a run says before it maps."""

from __future__ import annotations

import io
import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from rich.console import Console

from app.frames.open_recording import open_recording
from app.settings.run_config import InputSettings
from data_tools.checks.inspection import inspect_sequence
from data_tools.recordings.rgbd_calibration import read_rgbd_calibration
from data_tools.synthetic.synthetic_room import SyntheticRoom
from data_tools.writers.own_folder import write_folder
from razer.errors import UnusableFrame
from razer.frame import Frame
from razer.geometry import inverse
from tests.support.cli import razer
from tests.support.recordings import write_seven_scenes
from tests.support.spoilt import Spoilt, as_is, depth_moved, posed

N_FRAMES = 24


@pytest.fixture(scope="module")
def room() -> list[Frame]:
    recording = SyntheticRoom(3, n_frames=240, width=320, height=240)
    return [recording[index] for index in range(60, 60 + N_FRAMES)]


@pytest.fixture(scope="module")
def written(room: list[Frame], tmp_path_factory: pytest.TempPathFactory) -> dict[str, Path]:
    """Folders in our own layout: a correct one, one with world-to-camera poses, and one whose depth is another
    camera's."""
    folder = tmp_path_factory.mktemp("written")
    recording = SyntheticRoom(3, n_frames=240, width=320, height=240)
    whole_walk = [recording[index] for index in range(0, 240, 10)]  # few views of one thing would leave it open
    changes = {"right": (room, as_is), "inverted": (room, posed(inverse))}
    changes |= {"unregistered": (whole_walk, depth_moved(1.15, (10.0, 0.0)))}
    for name, (frames, change) in changes.items():
        write_folder(Spoilt(frames, change), folder / name)
    return {name: folder / name for name in changes}


def test_facts_are_those_of_the_recording(room: list[Frame]) -> None:
    def partly_blind(frame: Frame) -> Frame:
        if frame.index % 4 == 0:
            raise UnusableFrame(f"{frame.index}.png: broken")
        depth = np.full_like(frame.depth, 2.0)
        depth[:120] = 0
        return replace(frame, depth=depth)

    inspection = inspect_sequence(Spoilt(room, partly_blind))
    assert (inspection.n_frames, inspection.inspected, inspection.posed, len(inspection.bad)) == (24, 24, 18, 6)
    assert inspection.bad[0] == (0, "60.png: broken")
    assert inspection.rate_hz == pytest.approx(15.0)
    assert inspection.duration_s == pytest.approx(room[23].stamp - room[1].stamp)
    assert inspection.depth is not None
    assert (inspection.depth.low_m, inspection.depth.high_m, inspection.depth.valid) == (2.0, 2.0, 0.5)
    steps = np.diff([frame.pose[:3, 3] for i, frame in enumerate(room) if i % 4], axis=0)
    assert inspection.path_m == pytest.approx(np.linalg.norm(steps, axis=1).sum())


def test_a_correct_folder_is_described_and_not_blamed(
    written: dict[str, Path], room: list[Frame], capsys: pytest.CaptureFixture[str]
) -> None:
    code, out, err = razer(capsys, "inspect", written["right"])
    assert code == 0
    assert err.startswith("next: razer run")
    for part in ("folder", "24, 15.0 a second", "320x240", "24 of 24 frames", "nothing looks wrong"):
        assert part in out
    result = json.loads(razer(capsys, "inspect", written["right"], "--json")[1])
    assert (result["format"], result["layout"], result["frames"]) == (1, "folder", N_FRAMES)
    assert (result["findings"], result["bad"], result["poses"]["share"]) == ([], [], 1.0)
    assert result["depth"]["median_m"] == pytest.approx(np.median(np.stack([f.depth for f in room])), rel=0.03)


def test_poses_of_the_wrong_kind_are_named_and_a_run_warns(
    written: dict[str, Path], capsys: pytest.CaptureFixture[str]
) -> None:
    code, out, _ = razer(capsys, "inspect", written["inverted"])
    assert code == 0
    assert "LIKELY WRONG, poses" in out
    assert "fix: they are world-to-camera: invert each 4x4 matrix" in out
    for name, warned in (("inverted", True), ("right", False)):
        stream = io.StringIO()
        open_recording(written[name], InputSettings(), Console(file=stream, width=200))
        assert ("WARNING: the poses look wrong: they are world-to-camera" in stream.getvalue()) is warned
        assert bool(stream.getvalue()) is warned


def test_the_colour_camera_is_said_and_written(
    written: dict[str, Path], tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """Depth zoomed by 1.15 about the middle and moved by 10 pixels is colour zoomed by 1 / 1.15 and moved back."""
    path = tmp_path / "colour.json"
    _, out, _ = razer(capsys, "inspect", written["unregistered"], "--write", path)
    assert "LIKELY WRONG, registration: colour and depth are not registered" in out
    assert "--rgbd-calibration FILE.json" in out
    assert "the colour camera (fx " in out
    result = json.loads(razer(capsys, "inspect", written["unregistered"], "--json")[1])
    (finding,) = (finding for finding in result["findings"] if finding["about"] == "registration")
    rgbd = result["rgbd"]
    assert rgbd.keys() >= {"zoom", "shift_px", "baseline_m", "residual_px", "confident"}
    assert rgbd["confident"]
    assert f"{rgbd['mean_px']:.0f} pixels off" in finding["problem"]
    color = read_rgbd_calibration(path).color
    declared = json.loads((written["unregistered"] / "intrinsics.json").read_text())
    assert color.fx == pytest.approx(declared["fx"] / 1.15, rel=0.02)
    middle = 159.5 + (declared["cx"] - 159.5) / 1.15 - 10 / 1.15
    assert color.cx + 0.5 * color.fx * rgbd["baseline_m"][0] == pytest.approx(middle, abs=3)


def test_a_colour_camera_that_cannot_be_told_is_not_written(
    room: list[Frame], tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    write_folder(Spoilt(room[:3], as_is), tmp_path / "short")
    code, _, err = razer(capsys, "inspect", tmp_path / "short", "--write", tmp_path / "colour.json")
    assert code == 2
    assert err.count("\n") == 1
    assert "colour.json is not written: whether colour fits depth cannot be told" in err
    assert not (tmp_path / "colour.json").exists()


def test_a_flipped_axis_is_named_and_nothing_usable_is_exit_code_2(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    write_seven_scenes(tmp_path, frames=4)
    for path in tmp_path.glob("*.pose.txt"):
        np.savetxt(path, np.diag([1.0, -1.0, 1.0, 1.0]))
    code, out, _ = razer(capsys, "inspect", tmp_path)
    assert code == 2
    assert "left-handed" in out
    assert "negate one column of each rotation" in out


def test_a_run_says_that_poses_do_not_fit_and_that_a_camera_is_none(written: dict[str, Path], tmp_path: Path) -> None:
    """Those of another walk, and a principal point beside the image."""
    elsewhere = tmp_path / "elsewhere"
    other = SyntheticRoom(4, n_frames=240, width=320, height=240)
    np.savetxt(elsewhere, [other[10 * n].pose[:3].ravel() for n in range(N_FRAMES)])
    settings = InputSettings(poses_from=str(elsewhere), intrinsics="260,260,400,120")
    stream = io.StringIO()
    open_recording(written["right"], settings, Console(file=stream, width=1000))
    said = stream.getvalue()
    assert "WARNING: the poses do not fit the images: moved by the poses" in said
    assert "WARNING: the principal point 400, 120 lies outside of the image of 320x240" in said
    stream = io.StringIO()
    open_recording(written["right"], InputSettings(intrinsics="260,520,159.5,119.5"), Console(file=stream, width=1000))
    assert "make pixels that are no squares" in stream.getvalue()


def test_a_file_that_is_not_as_its_kind_is_said_to_be_so(
    written: dict[str, Path], room: list[Frame], tmp_path: Path
) -> None:
    """KITTI's poses are camera to world."""
    path = tmp_path / "inverted"
    np.savetxt(path, [inverse(frame.pose)[:3].ravel() for frame in room])
    stream = io.StringIO()
    open_recording(written["right"], InputSettings(poses_from=str(path)), Console(file=stream, width=1000))
    assert "WARNING: the poses look wrong: read as its kind has them, they are world-to-camera" in stream.getvalue()
    assert "so the file was not written as that kind is" in stream.getvalue()
