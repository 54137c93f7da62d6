"""What tracking makes of the time between frames."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from slam.config import SlamConfig
from slam.frontend.frame_tracker import FrameTracker
from slam.frontend.keyframes import STILL, Keyframes
from slam.frontend.view_registration import ViewRegistration

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
