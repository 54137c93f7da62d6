"""A colour camera beside the depth camera: its picture fits depth through the true calibration, and only so."""

from __future__ import annotations

import json
import pickle
from pathlib import Path

import numpy as np
import pytest

from data_tools.recordings.rgbd_alignment import Warp
from data_tools.registry import open_sequence
from data_tools.synthetic.camera.rgbd_misalignment import RgbdMisalignment
from data_tools.synthetic.synthetic_room import SyntheticRoom
from data_tools.synthetic.synthetic_scene import SyntheticScene
from data_tools.writers.table import write_recording
from razer.errors import BadInput
from razer.frame import Intrinsics

SIZE = (320, 240)
PLANTED = {
    "zoom": RgbdMisalignment(0.91),
    "shift": RgbdMisalignment(shift_px=(-9.0, 6.0)),
    "baseline": RgbdMisalignment(baseline_m=(0.05, -0.02, 0.03)),
    "together": RgbdMisalignment(1.08, (7.0, -5.0), (-0.04, 0.01, -0.02)),
}


@pytest.fixture(scope="module")
def plain() -> SyntheticScene:
    return SyntheticScene("tabletop", 1, 5, *SIZE)


@pytest.mark.parametrize("name", PLANTED)
def test_colour_fits_depth_through_the_true_calibration_alone(plain: SyntheticScene, name: str) -> None:
    scene = SyntheticScene("tabletop", 1, 5, *SIZE, misalignment=PLANTED[name])
    assert scene.calibration is not None
    warp = Warp.between(scene.intrinsics, scene.calibration.color, scene.calibration.color_from_depth)
    for index in (0, 3):
        frame, right = scene[index], plain[index]
        np.testing.assert_array_equal(frame.depth, right.depth)
        np.testing.assert_array_equal(frame.instance_ids, right.instance_ids)
        np.testing.assert_array_equal(frame.pose, right.pose)
        assert frame.intrinsics == right.intrinsics
        middle = (slice(30, -30), slice(30, -30))  # what both cameras see
        warped, raw, true = (
            rgb[middle].astype(float) for rgb in (warp.apply(frame.rgb, frame.depth), frame.rgb, right.rgb)
        )
        off, off_raw = np.abs(warped - true).mean(axis=2), np.abs(raw - true).mean(axis=2)
        assert np.median(off) < 3
        assert off.mean() < 0.5 * off_raw.mean()


def test_the_calibration_is_that_of_the_definition() -> None:
    depth = Intrinsics(640, 480, 525.0, 520.0, 300.0, 250.0)
    truth = RgbdMisalignment(0.9, (8.0, -4.0), (0.03, 0.01, -0.02)).calibration(depth)
    point = np.array([0.4, -0.2, 2.0])
    moved = truth.color_from_depth @ (*point, 1.0)
    np.testing.assert_allclose(moved[:3], point - (0.03, 0.01, -0.02))
    # Along one ray from the depth camera, far away: p from the image's middle becomes 0.9 p + shift.
    u, v, _ = depth.matrix @ (point / point[2])
    x, y, _ = truth.color.matrix @ (point / point[2])
    assert (x, y) == pytest.approx((319.5 + 0.9 * (u - 319.5) + 8, 239.5 + 0.9 * (v - 239.5) - 4))


def test_without_any_frames_are_as_before_and_nothing_is_written(plain: SyntheticScene, tmp_path: Path) -> None:
    none = SyntheticScene("tabletop", 1, 5, *SIZE, misalignment=RgbdMisalignment())
    assert none.calibration is None
    np.testing.assert_array_equal(none[2].rgb, plain[2].rgb)
    write_recording(none, tmp_path / "made", truth=none.truth(0.1))
    assert not (tmp_path / "made/truth/rgbd_calibration.json").exists()


@pytest.mark.parametrize("layout", ["own", "7scenes"])
def test_the_recording_declares_one_camera_and_the_truth_says_which(tmp_path: Path, layout: str) -> None:
    room = SyntheticRoom(2, 6, 160, 120, moved=True, misalignment=PLANTED["together"])
    assert room.calibration is not None
    assert pickle.loads(pickle.dumps(room)).calibration.to_json() == room.calibration.to_json()
    write_recording(room, tmp_path / "made", layout, truth=room.truth(0.1), lossless=True)
    back = open_sequence(tmp_path / "made")
    assert back.intrinsics.fx == pytest.approx(room.intrinsics.fx)
    np.testing.assert_array_equal(back[4].rgb, room[4].rgb)
    told = json.loads((tmp_path / "made/truth/rgbd_calibration.json").read_text())
    assert Intrinsics(**told["color"]) == room.calibration.color
    assert told["color"]["fx"] == pytest.approx(1.08 * room.intrinsics.fx)
    np.testing.assert_allclose(np.array(told["color_from_depth"])[:3, 3], (0.04, -0.01, 0.02))


@pytest.mark.parametrize(
    ("options", "words"),
    [
        ({"zoom": 3.0}, "zoom of 3"),
        ({"zoom": float("nan")}, "zoom of nan"),
        ({"shift_px": (float("nan"), 0.0)}, "shift"),
        ({"shift_px": (100.0, 0.0)}, "images are 160x120"),
        ({"baseline_m": (0.0, 30.0, 0.0)}, "baseline"),
    ],
)
def test_what_two_cameras_side_by_side_cannot_be_is_refused(options: dict, words: str) -> None:
    with pytest.raises(BadInput, match=words):
        RgbdMisalignment(**options).calibration(Intrinsics(160, 120, 130.0, 130.0, 79.5, 59.5))
