"""What tracking makes of the time between frames."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from razer.frame import Frame, Intrinsics
from slam.config import SlamConfig
from slam.frontend.color_calibration import ColorCalibration
from slam.frontend.depth_noise import DepthNoise
from slam.frontend.features import FeatureExtractor
from slam.frontend.frame_tracker import FrameTracker
from slam.frontend.keyframes import STILL, Keyframes, View
from slam.frontend.view_registration import ViewRegistration, leaves_open
from slam.se3 import angle_deg

TURN_DEG = 6.0


@pytest.fixture
def tracker(views):
    """A camera that turned by six degrees about its vertical axis from the frame before to the last, at time 0."""
    keyframes = Keyframes()
    keyframe = keyframes.add(views[10], np.eye(4), 0, 0.0)
    step = np.eye(4)
    step[:3, :3] = Rotation.from_euler("y", TURN_DEG, degrees=True).as_matrix()
    return FrameTracker(keyframes, ViewRegistration(SlamConfig()), keyframe, np.eye(4), 0.0, step)


@pytest.mark.parametrize(("gap_s", "per_s"), [(1 / 30, 30), (0.1, 10), (0.0, 30), (-1.0, 30)])
def test_a_camera_turns_by_what_it_turned_over_the_time_it_took(tracker, gap_s, per_s):
    """Stamps that are no times count as one frame of a video each."""
    np.testing.assert_allclose(tracker.turning_rad_s(gap_s), [0, np.radians(TURN_DEG) * per_s, 0], atol=1e-9)


@pytest.mark.parametrize("gap_s", [0.55, 4.0, 0.006])
def test_pictures_far_apart_in_time_or_turned_as_no_camera_turns_say_nothing_of_the_moment(tracker, gap_s):
    np.testing.assert_array_equal(tracker.turning_rad_s(gap_s), STILL)


def wall(rng):
    """A bare wall 2 m ahead that fills the view, with the noise of a sensor."""
    config, camera = SlamConfig(), Intrinsics(320, 240, 260.0, 260.0, 159.5, 119.5)
    sigma_m = DepthNoise(config.depth).at_rest(np.float64(2.0))
    depth = (2.0 + rng.normal(0, sigma_m, (240, 320))).astype(np.float32)
    frame = Frame(0, 0.2, np.full((240, 320, 3), 128, np.uint8), depth, camera)
    return View.of(frame, FeatureExtractor(config).extract(frame, ColorCalibration.nominal()), STILL, config)


@dataclass(frozen=True)
class Sliding(ViewRegistration):
    """Depth that noise, alike in both views, drew so far along x."""

    slid_m: float = 0.0

    def register(self, *arguments, **options):
        slid = np.eye(4)
        slid[0, 3] = self.slid_m
        return replace(super().register(*arguments, **options), target_from_source=slid)


@pytest.mark.parametrize("step_m", [0.1, 0.25])
def test_a_camera_that_passes_a_bare_wall_goes_on_as_before(rng, step_m):
    keyframes, step = Keyframes(), np.eye(4)
    step[0, 3] = step_m
    keyframe = keyframes.add(wall(rng), np.eye(4), 0, 0.0)
    tracker = FrameTracker(keyframes, Sliding(SlamConfig()), keyframe, np.eye(4), 0.0, step, knows_step=True)
    found = tracker.follow(wall(rng), ColorCalibration.nominal())
    assert found is not None
    pose = found[1].target_from_source
    np.testing.assert_allclose(pose[:3, 3], [step_m, 0, 0], atol=0.02)
    assert angle_deg(pose) < 1
    assert leaves_open(found[1])


def test_a_camera_of_which_no_view_said_how_it_moves_is_where_it_was_measured(rng):
    """A step that is none since nothing was measured yet is no motion so far."""
    keyframes = Keyframes()
    keyframe = keyframes.add(wall(rng), np.eye(4), 0, 0.0)
    tracker = FrameTracker(keyframes, Sliding(SlamConfig(), 0.1), keyframe, np.eye(4), 0.0)
    found = tracker.follow(wall(rng), ColorCalibration.nominal())
    assert found is not None
    assert found[1].target_from_source[0, 3] == pytest.approx(0.1, abs=0.03)
    assert not tracker.knows_step


def test_a_view_that_shows_the_motion_whole_tells_the_step(views):
    keyframes = Keyframes()
    keyframe = keyframes.add(views[10], np.eye(4), 0, 0.0)
    tracker = FrameTracker(keyframes, ViewRegistration(SlamConfig()), keyframe, np.eye(4), 0.0)
    assert tracker.follow(views[12], ColorCalibration.nominal()) is not None
    assert tracker.knows_step
