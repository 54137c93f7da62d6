"""Guessed intrinsics of a recording: refined before it is tracked or mapped, kept in the run, or said to stay."""

from __future__ import annotations

import io
import json
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest
from rich.console import Console

from app.frames.cameras.color_registration import ColorRegistration, register_color
from app.frames.cameras.refined_camera import camera_text, intrinsics_of_views, with_camera_of
from app.frames.open_recording import open_recording
from app.settings.config_file import read_run_config
from app.settings.run_config import InputSettings
from data_tools.recordings.sequence import RgbdSequence
from data_tools.synthetic.camera.sensor_model import SensorModel
from data_tools.synthetic.synthetic_room import SyntheticRoom
from data_tools.writers.own_folder import write_folder
from razer.errors import BadInput
from razer.frame import Intrinsics
from tests.slam.guessed_intrinsics import Guessed, guess_of, opened
from tests.support.cli import QUICK, razer
from tests.support.spoilt import Spoilt, as_is

N_FRAMES = 120
OPTIONS = (*QUICK, "--no-timeline", "--max-frames", 4)


@pytest.fixture(scope="module")
def walk(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("walk") / "recording"
    write_folder(SyntheticRoom(3, N_FRAMES, 160, 120, sensor=SensorModel.plain()), folder)
    return folder


@pytest.fixture(scope="module")
def guessed(walk: Path) -> str:
    true = camera_of(walk)
    return camera_text(replace(true, fx=true.fx * 0.85, fy=true.fy * 0.85))


@pytest.fixture(scope="module")
def refined(walk: Path, guessed: str) -> tuple[RgbdSequence, str]:
    return opened_with(walk, intrinsics=guessed, refine_intrinsics=True)


def camera_of(folder: Path) -> Intrinsics:
    content = json.loads((folder / "intrinsics.json").read_text())
    return Intrinsics(*(content[name] for name in ("width", "height", "fx", "fy", "cx", "cy")))


def opened_with(folder: Path, **settings: Any) -> tuple[RgbdSequence, str]:
    """A recording, and what was said when it was opened."""
    said = Console(file=io.StringIO(), width=1000)
    sequence = open_recording(folder, InputSettings(**settings), said)
    return sequence, said.file.getvalue()  # type: ignore[attr-defined]


def test_a_guess_is_refined_and_said_to_be(walk: Path, guessed: str, refined: tuple[RgbdSequence, str]) -> None:
    true, (sequence, said) = camera_of(walk), refined
    assert sequence.intrinsics.fx == pytest.approx(true.fx, rel=0.01)
    assert sequence.intrinsics.cx == pytest.approx(true.cx, abs=2)
    assert "intrinsics: focal lengths" in said
    assert f"guessed were {guessed}" in said
    assert sequence[0].intrinsics == sequence.intrinsics
    believed, said = opened_with(walk, intrinsics=guessed)
    assert camera_text(believed.intrinsics) == guessed
    assert "focal lengths" not in said


def test_settings_open_the_recording_again_with_what_was_found(
    walk: Path, guessed: str, refined: tuple[RgbdSequence, str]
) -> None:
    kept = with_camera_of(InputSettings(intrinsics=guessed, refine_intrinsics=True), refined[0])
    again, said = opened_with(walk, **kept.model_dump(exclude={"trust"}, exclude_none=True))
    assert camera_text(again.intrinsics) == camera_text(refined[0].intrinsics)
    assert not kept.refine_intrinsics
    assert "pairs of views" in str(kept.intrinsics_note)
    assert "refined" not in said
    believed = InputSettings(intrinsics="100,100,80,60")
    assert with_camera_of(believed, refined[0]) is believed


def test_views_that_do_not_turn_leave_the_guess(tmp_path: Path) -> None:
    frame = SyntheticRoom(3, 8, 160, 120)[0]
    still = [replace(frame, index=index, stamp=index / 10) for index in range(12)]
    write_folder(Spoilt(still, as_is), tmp_path / "still")
    sequence, said = opened_with(tmp_path / "still", intrinsics="150,150,80,60", refine_intrinsics=True)
    assert sequence.intrinsics.fx == 150
    assert "WARNING: the intrinsics cannot be refined:" in said
    assert "150,150,80,60, which stay" in said


def test_images_that_are_undistorted_have_been_calibrated(walk: Path) -> None:
    with pytest.raises(BadInput, match="leave --refine-intrinsics out"):
        opened_with(walk, intrinsics="150,150,80,60,0.1,0,0,0,0", refine_intrinsics=True)


@pytest.mark.full
def test_a_run_keeps_what_it_refined(walk: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    code, _, said = razer(capsys, "run", walk, "-o", tmp_path / "run", "--intrinsics", "guess", *OPTIONS)
    assert code == 0, said
    camera = json.loads((tmp_path / "run" / "camera.json").read_text())
    assert camera["fx"] == pytest.approx(camera_of(walk).fx, rel=0.01)
    config = read_run_config(tmp_path / "run" / "config.toml")
    assert config.input.intrinsics == ",".join(f"{camera[name]:.6g}" for name in ("fx", "fy", "cx", "cy"))
    assert config.input.intrinsics_note is not None
    assert not config.input.refine_intrinsics


@pytest.mark.full
def test_inspect_says_how_sure_intrinsics_are(walk: Path, capsys: pytest.CaptureFixture[str]) -> None:
    result = json.loads(razer(capsys, "inspect", walk, "--json")[1])
    estimate, true = result["intrinsics_estimate"], camera_of(walk)
    assert estimate["confident"]
    assert abs(estimate["fx"] - true.fx) < 4 * estimate["sigma_px"][0] + 0.3
    assert not [finding for finding in result["findings"] if finding["about"] == "intrinsics"]
    _, out, err = razer(capsys, "inspect", walk, "--intrinsics", "110,110,79.5,59.5")
    assert "LIKELY WRONG, intrinsics: pairs of views fit other ones" in out
    assert "--refine-intrinsics" in err


@pytest.mark.full
@pytest.mark.parametrize("name", ["redkitchen", "room:1:320", "room:2"])
@pytest.mark.parametrize("factor", [0.8, 1.2])
def test_recordings_are_found_again_within_a_percent(name: str, factor: float, real_data: Path) -> None:
    sequence = opened(str(real_data / name) if name == "redkitchen" else name)
    guess = guess_of(sequence.intrinsics, factor)
    recording = Guessed(sequence, guess)
    found = intrinsics_of_views(recording, register_color(recording, "auto", Console(quiet=True)))
    assert found.confident
    for part in ("fx", "fy"):
        assert getattr(found.intrinsics, part) == pytest.approx(getattr(sequence.intrinsics, part), rel=0.01)


@pytest.mark.full
def test_a_clip_of_two_seconds_of_fast_turns_does_not_tell(real_data: Path) -> None:
    clip = opened(str(real_data / "tum_fr1_rpy_head"))
    recording = Guessed(clip, guess_of(clip.intrinsics, 0.9))
    found = intrinsics_of_views(recording, ColorRegistration(recording.intrinsics))
    assert not found.confident
    assert "open by" in found.reason
