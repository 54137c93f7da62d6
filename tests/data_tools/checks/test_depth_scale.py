"""A wrong depth scale is caught with the right one named; a right one is left alone."""

from __future__ import annotations

from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from data_tools import open_sequence
from data_tools.checks.depth_scale import check_depth_scale, factor_from_steps
from data_tools.recordings.sequence import RgbdSequence
from razer.errors import UnusableFrame
from razer.frame import Frame, Intrinsics

TRUE_SCALES = {"redkitchen": 1000.0, "tum_fr1_rpy_head": 5000.0}
CAMERA = Intrinsics(320, 240, 260.0, 260.0, 159.5, 119.5)


@pytest.mark.parametrize(
    ("factor", "use_poses"),
    [(1.0, True), (5.0, True), (0.2, True), (1000.0, True), (0.001, True), (1.0, False), (5.0, False), (0.2, False)],
)
@pytest.mark.parametrize("clip", TRUE_SCALES)
def test_planted_scales_on_real_clips(real_data: Path, clip: str, factor: float, use_poses: bool) -> None:
    true = TRUE_SCALES[clip]
    sequence = open_sequence(real_data / clip, depth_scale=true * factor, use_poses=use_poses)
    report = check_depth_scale(sequence)
    if factor == 1:
        assert (report.verdict, report.likely) == ("ok", None)
    else:
        assert (report.verdict, report.likely) == ("suspicious", true)


def test_poses_in_millimetres_are_not_blamed_on_depth(real_data: Path) -> None:
    report = check_depth_scale(PosesInMillimetres(open_sequence(real_data / "redkitchen")))
    assert (report.verdict, report.likely) == ("suspicious", None)
    assert "poses are not in metres" in report.reason


@dataclass
class PosesInMillimetres:
    """A recording with its positions multiplied by 1000."""

    recording: RgbdSequence

    def __getattr__(self, name: str) -> Any:
        return getattr(self.recording, name)

    def __len__(self) -> int:
        return len(self.recording)

    def __getitem__(self, index: int) -> Frame:
        frame = self.recording[index]
        pose = frame.pose.copy()
        pose[:3, 3] *= 1000
        return frame.at(pose)


@dataclass
class Corner:
    """A camera sliding along a textured wall with a step in it, `depth_factor` times too deep; metres."""

    depth_factor: float = 1.0
    pose_factor: float = 1.0
    has_poses: bool = True
    broken: int | None = None
    n_frames: int = 24

    name = "corner"
    intrinsics = CAMERA
    depth_scale = 1000.0

    def __post_init__(self) -> None:
        self._texture = np.random.default_rng(0).integers(0, 255, (400, 900, 3)).astype(np.uint8)

    def __len__(self) -> int:
        return self.n_frames

    def __getitem__(self, index: int) -> Frame:
        if index == self.broken:
            raise UnusableFrame("broken on purpose")
        v, u = np.mgrid[: CAMERA.height, : CAMERA.width]
        x_m = 0.02 * index
        depth = np.where(v < 120, 2.0, 1.5)
        columns = ((u - CAMERA.cx) / CAMERA.fx * depth + x_m) * 100 + 300
        rows = v * depth / 2.0
        rgb = self._texture[rows.astype(int), columns.astype(int)]
        pose = np.eye(4)
        pose[0, 3] = x_m * self.pose_factor
        frame = Frame(index, index / 30, rgb, (depth * self.depth_factor).astype(np.float32), CAMERA, pose)
        return frame if self.has_poses else replace(frame, world_from_camera=None)


def test_a_correct_recording_is_not_flagged() -> None:
    assert check_depth_scale(Corner()).verdict == "ok"


@pytest.mark.parametrize(("factor", "likely"), [(5.0, 5000), (0.2, None), (10.0, 10000), (0.1, 100), (0.001, 1)])
def test_motion_finds_the_scale_without_any_sensor_model(factor: float, likely: float | None) -> None:
    report = check_depth_scale(Corner(depth_factor=factor))
    assert report.verdict == "suspicious"
    # The likely scale undoes the factor; 200 is no scale in use, so it is reported as measured.
    assert report.likely == pytest.approx(likely or 200, rel=0 if likely else 0.15)


@pytest.mark.parametrize("factor", [0.7, 1.5])
def test_moderate_disagreement_is_not_shouted_about(factor: float) -> None:
    assert check_depth_scale(Corner(depth_factor=factor)).verdict == "ok"


def test_poses_that_do_not_fit_decide_nothing() -> None:
    assert check_depth_scale(Corner(pose_factor=-1.0)).verdict == "ok"


def test_a_camera_at_rest_decides_nothing() -> None:
    assert check_depth_scale(Corner(pose_factor=0.0)).verdict == "ok"


@pytest.mark.parametrize(
    ("factor", "verdict", "likely"),
    [(1.0, "ok", None), (0.001, "suspicious", 1), (1000.0, "suspicious", None)],  # 1e6 is no scale in use
)
def test_without_poses_the_median_decides(factor: float, verdict: str, likely: float | None) -> None:
    report = check_depth_scale(Corner(depth_factor=factor, has_poses=False))
    assert (report.verdict, report.likely) == (verdict, likely)


def test_broken_frames_are_left_out() -> None:
    assert check_depth_scale(Corner(broken=0, depth_factor=5)).likely == 5000
    assert check_depth_scale(Corner(n_frames=1)).verdict == "ok"
    assert check_depth_scale(Corner(n_frames=1, broken=0)).verdict == "ok"


def ramp(near_m: float, far_m: float) -> Frame:
    depth = np.linspace(near_m, far_m, 320 * 240).reshape(240, 320)
    return Frame(0, 0.0, np.zeros((240, 320, 3), np.uint8), depth.astype(np.float32), CAMERA)


def test_steps_of_disparity_tell_the_scale() -> None:
    exact = ramp(0.6, 4.0)
    disparity = np.rint(8 * 580 * 0.075 / exact.depth)
    millimetres = np.rint(8 * 580 * 0.075 / disparity * 1000)
    for factor in (1.0, 7.0, 0.001):
        stepped = replace(exact, depth=(millimetres / 1000 * factor).astype(np.float32))
        estimate = factor_from_steps([stepped])
        assert estimate is not None
        assert estimate.factor == pytest.approx(1 / factor, rel=0.05)


def test_depth_without_disparity_steps_tells_nothing() -> None:
    exact = ramp(0.6, 4.0)
    assert factor_from_steps([exact]) is None
    assert factor_from_steps([replace(exact, depth=np.rint(exact.depth * 1000).astype(np.float32) / 1000)]) is None
    assert factor_from_steps([replace(exact, depth=np.rint(exact.depth * 20).astype(np.float32) / 20)]) is None
