"""The colour-camera model against the plain projection of its own calibration, and against finite differences."""

from __future__ import annotations

import numpy as np
import pytest

from data_tools.calibration.color_camera import REGISTERED, ColorProjection
from razer.frame import Intrinsics
from razer.geometry import project, transform_points

DEPTH_CAMERA = Intrinsics(640, 480, 525.0, 520.0, 310.0, 250.0)
MODEL = ColorProjection(DEPTH_CAMERA)
PARAMETERS = np.array([0.92, 7.0, -4.0, 0.03, -0.01, 0.02, 0.015])
RNG = np.random.default_rng(0)
RAYS, INVERSE_DEPTH = RNG.uniform(-0.5, 0.5, (50, 2)), RNG.uniform(0.2, 1.5, 50)


def test_pixels_are_those_of_the_calibration() -> None:
    calibration = MODEL.calibration(PARAMETERS)
    points = np.column_stack([RAYS, np.ones(50)]) / INVERSE_DEPTH[:, None]
    u, v, _ = project(transform_points(calibration.color_from_depth, points), calibration.color.matrix)
    np.testing.assert_allclose(MODEL.pixels(PARAMETERS, RAYS, INVERSE_DEPTH), np.stack([u, v], axis=1), atol=1e-9)


def test_far_points_are_zoomed_about_the_middle_and_shifted() -> None:
    rays = np.array([[0.1, 0.2]])
    at_depth = MODEL.pixels(REGISTERED, rays, np.zeros(1))
    middle = np.array([319.5, 239.5])
    expected = middle + 0.92 * (at_depth - middle) + (7.0, -4.0)
    np.testing.assert_allclose(MODEL.pixels(np.append(PARAMETERS[:6], 0.0), rays, np.zeros(1)), expected)


def test_a_roll_turns_the_image_about_its_principal_point() -> None:
    camera = ColorProjection(Intrinsics(640, 480, 500.0, 500.0, 319.5, 239.5))
    rays = np.array([[0.2, 0.0]])
    ((u, v),) = camera.pixels(np.append(REGISTERED[:6], np.radians(90)), rays, np.zeros(1))
    assert (u, v) == pytest.approx((319.5, 239.5 + 100))


def test_the_jacobian_is_that_of_finite_differences() -> None:
    jacobian = MODEL.jacobian(PARAMETERS, RAYS, INVERSE_DEPTH)
    for i, step in enumerate(np.diag([1e-6, 1e-4, 1e-4, 1e-6, 1e-6, 1e-6, 1e-6])):
        up, down = (MODEL.pixels(PARAMETERS + sign * step, RAYS, INVERSE_DEPTH) for sign in (1, -1))
        np.testing.assert_allclose(jacobian[:, :, i], (up - down) / (2 * step[i]), rtol=1e-4, atol=1e-4)


@pytest.mark.parametrize(
    ("change", "off_px"),
    [([0, 3, 4, 0, 0, 0, 0], 5.0), ([0, 0, 0, 0.02, 0, 0, 0], 0.02 * 525 / 1.5), ([0.1, 0, 0, 0, 0, 0, 0], None)],
)
def test_displacement_is_in_pixels_at_a_depth(change: list[float], off_px: float | None) -> None:
    off = MODEL.displacement_px(REGISTERED + change, REGISTERED, np.array([1.5]))
    expected = 0.1 * np.hypot(319.5, 239.5) if off_px is None else off_px
    assert off.max() == pytest.approx(expected, rel=1e-6)


def test_deviations_follow_from_the_covariance() -> None:
    covariance = np.diag([0, 4.0, 0, 0, 0, 0, 0])
    np.testing.assert_allclose(MODEL.sigma_px(REGISTERED, covariance, np.array([1.0, 3.0])), 2.0)
