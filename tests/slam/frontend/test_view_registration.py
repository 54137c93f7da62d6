"""The motion between two views of a simulated room."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from razer.geometry import inverse
from slam.config import SlamConfig
from slam.frontend.color_calibration import ColorCalibration
from slam.frontend.icp import IcpResult
from slam.frontend.view_registration import ViewRegistration, is_trusted, most_plausible
from slam.se3 import angle_deg, exp_se3, length_m


def test_two_views_of_a_room_are_brought_together_from_any_guess_nearby(room, views):
    truth = inverse(room[10].pose) @ room[12].pose
    registration = ViewRegistration(SlamConfig())
    for twist in ([0, 0, 0, 0, 0, 0], [0.02, -0.02, 0.01, 0.03, -0.03, 0.02], [-0.03, 0.01, 0.02, -0.04, 0.01, 0.03]):
        guess = exp_se3(np.array(twist)) @ truth
        result = registration.register(views[10], views[12], [guess], ColorCalibration.nominal())
        assert result is not None
        assert is_trusted(result)
        off = inverse(truth) @ result.target_from_source
        assert length_m(off) < 0.006
        assert angle_deg(off) < 0.15


def result(overlap, fit_where_shared):
    information = np.eye(6)
    shares = overlap, 0.99, overlap * fit_where_shared
    return IcpResult(np.eye(4), information, information, *shares, 0.6, 30, ColorCalibration.nominal())


@pytest.mark.parametrize(
    ("first", "second", "chosen"),
    [
        # A turn in front of a wall: to lie on each other is no sign that views show the same.
        (result(1.0, 0.905), result(0.93, 0.914), 1),
        (result(1.0, 0.914), result(0.93, 0.905), 0),
        (result(0.93, 0.914), result(1.0, 0.905), 0),
        (result(0.9, 0.912), result(0.9, 0.914), 0),  # noise: the motion so far is taken
        (result(0.9, 0.90), result(0.1, 1.0), 0),  # a corner of the view fits anywhere
    ],
)
def test_the_start_is_taken_whose_depth_fits_best_where_both_views_have_it(first, second, chosen):
    assert most_plausible([first, second]) is (first, second)[chosen]


def test_a_wrong_start_does_not_win_because_the_camera_is_said_to_have_turned(views, monkeypatch):
    """Depth that may have been smeared fits everywhere; this was not, as the right start shows."""
    wrong = exp_se3(np.array([0, 0, 0, 5.0, 0, 0]))

    def fits(source, target, guess, correspondences, calibration, noise, levels):
        is_right = length_m(guess) < 1.0
        fit, rms = (0.83, 0.6) if is_right else (0.5, 1.4)
        fit, rms = (0.95, 0.2) if noise.smear else (fit, rms)
        return replace(result(1.0, fit), target_from_source=guess, rms=rms)

    monkeypatch.setattr("slam.frontend.view_registration.icp", fits)
    target, source = (views[n].turning(np.array([0.0, 2.0, 0.0])) for n in (10, 12))
    for guesses in ([np.eye(4), wrong], [wrong, np.eye(4)]):
        found = ViewRegistration(SlamConfig()).register(target, source, guesses, ColorCalibration.nominal())
        assert found is not None
        assert length_m(found.target_from_source) < 1.0
        assert found.rms == 0.6


def test_a_motion_that_cannot_be_competes_with_none_that_can(room, views):
    truth = inverse(room[10].pose) @ room[12].pose
    registration, nominal = ViewRegistration(SlamConfig()), ColorCalibration.nominal()
    guesses = [exp_se3(np.array([0, 0.5, 0, 0.4, 0, 0])) @ truth, truth]
    asked = []

    def may_be(motion):
        asked.append(motion)
        return length_m(inverse(truth) @ motion) > 0.05

    free = registration.register(views[10], views[12], guesses, nominal)
    assert length_m(inverse(truth) @ free.target_from_source) < 0.006
    held = registration.register(views[10], views[12], guesses, nominal, may_be=may_be)
    assert len(asked) > 1
    assert length_m(inverse(truth) @ held.target_from_source) > 0.05


@pytest.mark.parametrize(
    ("agreement", "n_features", "trusted"), [(0.6, 0, False), (0.7, 0, True), (0.6, 10, True), (0.45, 10, False)]
)
def test_half_of_the_depth_is_not_enough_where_no_feature_agrees(agreement, n_features, trusted):
    """Two views of different places that both show floor and wall."""
    certain = 1e6 * np.eye(6)
    shares = 0.7, agreement, 0.7 * agreement
    found = IcpResult(np.eye(4), certain, certain, *shares, 0.7, n_features, ColorCalibration.nominal())
    assert is_trusted(found) is trusted
