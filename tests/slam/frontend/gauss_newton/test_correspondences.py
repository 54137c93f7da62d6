"""Matched features: their residuals, and the motion they alone lead to."""

from __future__ import annotations

import cv2
import numpy as np
import pytest

from razer.geometry import inverse
from slam.config import FeatureSettings
from slam.frontend.color_calibration import ColorCalibration
from slam.frontend.features import match_features
from slam.frontend.gauss_newton.correspondences import Correspondences, solve_pnp
from slam.se3 import angle_deg, exp_se3, length_m
from tests.support.planted_correspondences import planted


def test_features_alone_find_the_motion_without_a_guess(room, views):
    truth = inverse(room[10].pose) @ room[12].pose
    pairs = match_features(views[10].features, views[12].features, FeatureSettings())
    correspondences = Correspondences.of(views[10].features, views[12].features, pairs, np.zeros(3), np.zeros(3))
    start = solve_pnp(correspondences, ColorCalibration.nominal(), 100)
    assert start is not None
    assert length_m(inverse(truth) @ start) < 0.1
    assert angle_deg(inverse(truth) @ start) < 2


@pytest.mark.parametrize(("shift_m", "is_start"), [(1.0, True), (1e39, False), (np.nan, False)])
def test_a_motion_to_nowhere_is_no_start(monkeypatch, rng, shift_m, is_start):
    correspondences, _ = planted(ColorCalibration.nominal().parameters, 40, rng)
    found = True, np.zeros((3, 1)), np.full((3, 1), shift_m), np.arange(40)[:, None]
    monkeypatch.setattr(cv2, "solvePnPRansac", lambda *_, **__: found)
    assert (solve_pnp(correspondences, ColorCalibration.nominal(), 100) is not None) is is_start


def test_residuals_vanish_at_the_truth_and_their_derivatives_are_right(rng):
    parameters = np.array([1.05, 0.02, 0.01, 0.01, -0.02, 0.02, 0.025])
    correspondences, truth = planted(parameters, 40, rng, rng.normal(0, 0.8, (2, 3)))
    np.testing.assert_allclose(correspondences.residuals(truth, parameters), 0, atol=1e-6)
    pose, off = exp_se3(rng.normal(0, 0.01, 6)) @ truth, parameters + rng.normal(0, 0.01, 7)
    term = correspondences.term(pose, off)

    # The gradient of the Cauchy cost 2 log(1 + r^2 / 4), by central differences.
    def cost(x):
        squared = (correspondences.residuals(exp_se3(x[:6]) @ pose, off + x[6:]) ** 2).sum(axis=1)
        return 2 * np.log1p(squared / 4).sum()

    steps = 1e-6 * np.eye(13)
    numeric = np.array([(cost(step) - cost(-step)) / 2e-6 for step in steps])
    np.testing.assert_allclose(-term.gradient, numeric, rtol=1e-4, atol=1e-4 * np.abs(numeric).max())
