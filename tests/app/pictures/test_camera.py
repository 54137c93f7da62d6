"""The camera of a picture: rays and projection belong together, and what is to be seen fits."""

from __future__ import annotations

import numpy as np
import pytest

from app.pictures.camera import axes_towards, fitted_camera

UP, HEADING = np.array([0.0, 0.0, 1.0]), np.array([1.0, 0.0, 0.0])


def cloud():
    return np.random.default_rng(3).uniform([-2, -1, 0], [3, 4, 2.5], (400, 3))


@pytest.mark.parametrize("is_orthographic", [False, True])
@pytest.mark.parametrize("elevation", [0.0, 40.0, 90.0])
def test_a_point_in_the_camera_is_as_deep_and_as_slanted_as_it_is_projected(is_orthographic, elevation):
    axes = axes_towards(UP, HEADING, elevation)
    camera = fitted_camera(axes, cloud(), (80, 60), 5, is_orthographic=is_orthographic)
    points = cloud()
    local = camera.local(points).astype(float)
    x, y = (camera.depth_focal_px * local[:, :2] / local[:, 2:] + camera.center_px).T
    np.testing.assert_allclose(np.stack([x, y], axis=1), camera.project(points), atol=2e-2)
    inside = (x > 0) & (x < 80) & (y > 0) & (y < 60)
    slant = camera.slant(0, 60)[y[inside].astype(int), x[inside].astype(int)]
    if not is_orthographic:
        np.testing.assert_allclose(
            slant * local[inside, 2], np.linalg.norm(points[inside] - camera.eye, axis=1), rtol=2e-2
        )
    else:
        assert (slant == 1).all()


@pytest.mark.parametrize("elevation", [0.0, 40.0, 90.0])
def test_axes_are_a_right_handed_frame_that_looks_back_at_the_map(elevation):
    axes = axes_towards(UP, HEADING, elevation)
    np.testing.assert_allclose(axes @ axes.T, np.eye(3), atol=1e-12)
    np.testing.assert_allclose(np.cross(axes[0], axes[1]), axes[2], atol=1e-12)
    assert axes[2] @ HEADING == pytest.approx(-np.cos(np.radians(elevation)))
    assert axes[1] @ UP <= 1e-12  # up is up in the picture


@pytest.mark.parametrize("crops", [False, True])
@pytest.mark.parametrize("is_orthographic", [False, True])
def test_points_fit_with_their_margin_and_touch_it(crops, is_orthographic):
    points, margin = cloud(), 12
    axes = axes_towards(UP, HEADING, 35)
    camera = fitted_camera(axes, points, (300, 300), margin, crops=crops, is_orthographic=is_orthographic)
    low, high = np.quantile(camera.project(points), [0.002, 0.998], axis=0)
    width, height = camera.size
    free = np.array([low[0], low[1], width - high[0], height - high[1]])
    assert free.min() == pytest.approx(margin, abs=1)
    if crops:
        assert free.max() < margin + 2
        assert min(camera.size) < 300
    else:
        assert camera.size == (300, 300)


def test_more_samples_are_the_same_view():
    camera = fitted_camera(axes_towards(UP, HEADING, 35), cloud(), (300, 200), 12)
    np.testing.assert_allclose(camera.scaled(3).project(cloud()), 3 * camera.project(cloud()), atol=1e-9)


def test_a_single_point_and_a_few_far_fragments_do_no_harm():
    axes = axes_towards(UP, HEADING, 35)
    camera = fitted_camera(axes, np.ones((1, 3)), (100, 100), 5)
    np.testing.assert_allclose(camera.project(np.ones((1, 3))), [[50, 50]], atol=1e-6)
    many = np.concatenate([np.repeat(cloud(), 10, axis=0), [[900.0, 900, 900]]])
    near = fitted_camera(axes, many, (300, 300), 5).project(cloud())
    assert np.ptp(near, axis=0).max() > 250
