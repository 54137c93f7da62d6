"""What the motion so far decides, and what it leaves to what both views show."""

from __future__ import annotations

import numpy as np
import pytest

from slam.frontend.color_calibration import ColorCalibration
from slam.frontend.icp import IcpResult
from slam.frontend.motion_prior import SHIFT_ACCELERATION, TURN_ACCELERATION, MotionPrior
from slam.pose_edge import EDGE_SHARE
from slam.se3 import angle_deg, exp_se3, length_m

GAP_S = 0.2
PREDICTED = exp_se3(np.array([0.02, 0.0, 0.01, 0.3, 0.1, 0.0]))


def registered(information, pose=None):
    """A registration that found no motion at all."""
    pose = np.eye(4) if pose is None else pose
    return IcpResult(pose, information, information, 1.0, 1.0, 1.0, 0.5, 0, ColorCalibration.nominal())


def test_the_prior_grows_by_what_hands_do_in_the_time_between():
    sigma = np.diag(MotionPrior(PREDICTED, GAP_S).information) ** -0.5
    np.testing.assert_allclose(sigma[:3], TURN_ACCELERATION * GAP_S**2 / 2)
    np.testing.assert_allclose(sigma[3:], SHIFT_ACCELERATION * GAP_S**2 / 2)


def test_what_is_open_goes_on_as_before_and_what_is_known_stays():
    """Along a corridor, x: all but the shift along it is known."""
    known = 1e9 * np.diag([1.0, 1, 1, 0, 1, 1])
    moved = MotionPrior(PREDICTED, GAP_S).carried_on(registered(known))
    np.testing.assert_allclose(moved[:3, 3], [0.3, 0, 0], atol=1e-3)
    assert angle_deg(moved) < 0.01


def test_where_nothing_is_known_the_camera_is_where_it_was_expected_and_where_all_is_where_it_was_measured():
    prior = MotionPrior(PREDICTED, GAP_S)
    np.testing.assert_allclose(prior.carried_on(registered(np.zeros((6, 6)))), PREDICTED, atol=5e-3)
    assert length_m(prior.carried_on(registered(1e12 * np.eye(6)))) < 1e-4


@pytest.mark.parametrize("share", [0.25, 1.0, 4.0])
def test_between_the_two_each_counts_by_what_it_knows(share):
    prior = MotionPrior(exp_se3(np.array([0, 0, 0, 0.1, 0, 0])), GAP_S)
    moved = prior.carried_on(registered(share * prior.information / EDGE_SHARE))
    assert moved[0, 3] == pytest.approx(0.1 / (1 + share))
