"""The colour camera, learnt from motions that are known."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from slam.frontend.color_calibration import NOMINAL, ColorCalibration, bearing_derivatives, readout_flow
from slam.se3 import exp_se3
from tests.support.planted_correspondences import planted


def test_readout_flow_is_what_a_camera_that_turns_sees_a_moment_later(rng):
    rays, turning = rng.uniform(-0.6, 0.6, (30, 2)), np.array([0.4, -1.1, 0.3])
    # A ray read `moment` after the image's middle, in the axes the camera has in the middle.
    moment = 1e-6
    turned = np.column_stack([rays, np.ones(30)]) @ exp_se3(np.r_[turning * moment, 0, 0, 0])[:3, :3].T
    expected = (turned[:, :2] / turned[:, 2:] - rays) / moment
    np.testing.assert_allclose(readout_flow(rays, np.ones(30), turning), expected, atol=1e-5)
    np.testing.assert_allclose(readout_flow(rays, np.full(30, -0.5), turning), -expected / 2, atol=1e-5)


def test_how_long_the_colour_camera_reads_is_learnt_while_it_turns(rng):
    true = np.array([1.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.02])
    camera = ColorCalibration.nominal()
    for _ in range(40):
        correspondences, truth = planted(true, 150, rng, rng.normal(0, 0.7, (2, 3)))
        camera = learnt_at(truth, correspondences, camera, rng)
    assert camera.parameters[6] == pytest.approx(0.02, abs=0.001)
    assert camera.parameters[0] == pytest.approx(1.0, abs=0.01)


def learnt_at(truth, correspondences, camera, rng):
    """The camera after correspondences, made noisy, of a motion that is known."""
    noise = rng.normal(0, 0.7 / 525, correspondences.source_rays.shape)
    noisy = replace(correspondences, source_rays=correspondences.source_rays + noise)
    bend = np.zeros_like(camera.parameters)
    for _ in range(3):
        term = noisy.term(truth, camera.parameters + bend)
        likelihood = term.information[6:, 6:]
        bend += np.linalg.solve(likelihood + camera.information, term.gradient[6:] - camera.information @ bend)
    return camera.updated(bend, likelihood)


def test_the_colour_camera_is_learnt_from_motions_that_depth_tells(rng):
    true = np.array([1.1, -0.03, 0.0, 0.02, -0.01, 0.025, 0.0])
    camera = ColorCalibration.nominal()
    for _ in range(60):
        correspondences, truth = planted(true, 150, rng)
        camera = learnt_at(truth, correspondences, camera, rng)
    assert camera.parameters[0] == pytest.approx(1.1, abs=0.01)
    rays = rng.uniform(-0.5, 0.5, (100, 2))
    off = camera.bearings(rays) - ColorCalibration(true, camera.information).bearings(rays)
    assert np.abs(off).max() < 3 / 525  # it was up to 30 pixels


def test_a_registered_camera_stays_nominal(rng):
    camera = ColorCalibration.nominal()
    correspondences, truth = planted(NOMINAL, 200, rng)
    noisy = replace(correspondences, source_rays=correspondences.source_rays + rng.normal(0, 1.5 / 525, (200, 2)))
    term = noisy.term(truth, camera.parameters)
    likelihood = term.information[6:, 6:]
    bend = np.linalg.solve(likelihood + camera.information, term.gradient[6:])
    assert np.abs(camera.updated(bend, likelihood).parameters - NOMINAL).max() < 0.03


def test_rays_of_the_colour_camera_lead_back_to_those_of_depth(rng):
    camera = ColorCalibration(np.array([1.1, -0.05, 0.1, 0.02, -0.01, -0.05, 0.0]), np.eye(7))
    rays, depth_m = rng.uniform(-0.6, 0.6, (200, 2)), rng.uniform(0.5, 4.0, 200)
    seen = camera.color_rays(rays, depth_m)
    np.testing.assert_allclose(camera.depth_rays(seen, depth_m), rays, atol=1e-4)
    assert np.abs(seen - rays).max() > 0.05
    np.testing.assert_array_equal(ColorCalibration.nominal().color_rays(rays, depth_m), rays)


def test_bearings_are_what_their_derivatives_by_linear_parameters_add_up_to(rng):
    camera = ColorCalibration(NOMINAL + rng.normal(0, 0.05, len(NOMINAL)), np.eye(7))
    rays = rng.uniform(-0.6, 0.6, (50, 2))
    expected = bearing_derivatives(rays, np.zeros_like(rays)) @ camera.parameters
    np.testing.assert_allclose(camera.bearings(rays), expected, atol=1e-12)


def test_a_lens_that_nobody_has_yields_rays_nonetheless(rng):
    bent = ColorCalibration(np.array([0.7, -0.9, 0.9, 0.0, 0.0, 0.3, 0.0]), np.eye(7))
    assert np.isfinite(bent.color_rays(rng.uniform(-1.5, 1.5, (500, 2)), np.full(500, 0.3))).all()
