"""Depth and features as one least-squares problem."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from razer.frame import Intrinsics
from razer.geometry import inverse, rotation_error
from slam.config import DepthSettings
from slam.frontend.color_calibration import N_PARAMETERS, ColorCalibration
from slam.frontend.depth_noise import DepthNoise
from slam.frontend.depth_pyramid import DepthPyramid, fine_depth
from slam.frontend.gauss_newton.correspondences import ColorTerm, Correspondences
from slam.frontend.icp import FINE, icp
from slam.frontend.view_registration import is_at_rest, is_trusted, leaves_open
from slam.se3 import exp_se3, length_m


def test_features_say_where_a_bare_wall_leaves_the_motion_open(rng):
    camera = Intrinsics(640, 480, 525.0, 525.0, 319.5, 239.5)
    wall = np.full((480, 640), 2.0, np.float32)
    grids = DepthPyramid(*fine_depth(wall, camera, max_depth_m=4.0)).levels
    noise = DepthNoise(DepthSettings())
    truth = exp_se3(np.array([0, 0, 0, 0.03, -0.02, 0.0]))
    rays = rng.uniform(-0.5, 0.5, (80, 2))
    points = np.column_stack([rays, np.ones(80)]) * 2.0
    source_rays = (points - truth[:3, 3])[:, :2] / 2.0
    correspondences = Correspondences.at_rest(rays, np.full(80, 2.0), source_rays, np.full(80, 1.5 / 525))
    alone = icp(grids, grids, np.eye(4), Correspondences.none(), ColorCalibration.nominal(), noise)
    assert not is_trusted(alone)
    assert leaves_open(alone)
    result = icp(grids, grids, np.eye(4), correspondences, ColorCalibration.nominal(), noise)
    assert length_m(inverse(truth) @ result.target_from_source) < 0.002
    assert is_trusted(result)
    assert not leaves_open(result)


def test_the_noise_of_normals_does_not_hide_that_a_bare_wall_leaves_the_motion_open(rng):
    """Each normal is a few degrees off, as if the wall were rough; the other view's is off otherwise."""
    camera = Intrinsics(320, 240, 262.5, 262.5, 159.5, 119.5)
    settings, none = DepthSettings(), Correspondences.none()
    sigma_m = DepthNoise(settings).at_rest(np.float64(2.0))
    views = [
        DepthPyramid(
            *fine_depth((2.0 + rng.normal(0, sigma_m, (240, 320))).astype(np.float32), camera, max_depth_m=4.0)
        ).levels
        for _ in range(2)
    ]
    result = icp(*views, np.eye(4), none, ColorCalibration.nominal(), DepthNoise(settings))
    assert result.agreement > 0.9
    values, axes = np.linalg.eigh(result.information)
    open_axes = np.abs(axes[:, :3])  # shifts along the wall, and turns about its normal
    assert open_axes[[0, 1, 5]].max() < 0.2
    assert values[:3].max() < 0.02 * values[3]
    assert leaves_open(result)
    assert max(result.solved_sigma) < 0.1 * max(result.sigma)


CAMERA = Intrinsics(320, 240, 262.5, 262.5, 159.5, 119.5)


def test_nor_does_what_the_noise_of_two_views_has_in_common_by_chance(rng):
    """In nine of ten pairs: along one axis or another normals agree a little, as if the wall were not quite bare."""
    settings, nominal = DepthSettings(), ColorCalibration.nominal()
    noise = DepthNoise(settings)
    sigma_m, opened = noise.at_rest(np.float64(2.0)), []
    for _ in range(20):
        walls = (2.0 + rng.normal(0, sigma_m, (2, 240, 320))).astype(np.float32)
        views = [DepthPyramid(*fine_depth(wall, CAMERA, max_depth_m=4.0)).levels for wall in walls]
        result = icp(*views, np.eye(4), Correspondences.none(), nominal, noise)
        known = np.sort(np.linalg.eigvalsh(result.information))
        opened.append(known[2] < 10 and known[3] > 1e4)  # three axes and no more
    assert np.mean(opened) >= 0.9


def corridor(rng):
    """Depth of a corridor without an end, under the noise of a Kinect, which reads nothing from walls seen edge-on."""
    v, u = np.mgrid[: CAMERA.height, : CAMERA.width]
    x, y = (u - CAMERA.cx) / CAMERA.fx, (v - CAMERA.cy) / CAMERA.fy
    z = np.minimum(0.7 / np.abs(x), 1.2 / np.abs(y))
    read = z + rng.normal(0, DepthNoise(DepthSettings()).at_rest(z.clip(0, 6)))
    read[(rng.random(z.shape) < 0.3 * (z - 1)) | (z > 6)] = 0
    return DepthPyramid(*fine_depth(read.astype(np.float32), CAMERA, max_depth_m=4.0)).levels


def test_depth_of_a_corridor_without_an_end_pulls_nowhere_along_it(rng):
    """Where the camera is believed to be it stays: nothing says otherwise. Walls that taper with the distance from the
    camera would draw it to where the other view was."""
    none, settings = Correspondences.none(), DepthSettings()
    moved_m = []
    for ahead_m in (1.0, 1.0, 1.0, -1.0, -1.0, -1.0):
        truth = exp_se3(np.array([0, 0, 0, 0, 0, ahead_m]))
        result = icp(corridor(rng), corridor(rng), truth, none, ColorCalibration.nominal(), DepthNoise(settings))
        assert result.agreement > 0.9
        moved_m.append((inverse(truth) @ result.target_from_source)[2, 3] * np.sign(ahead_m))
    assert abs(np.mean(moved_m)) < 0.015
    assert np.abs(moved_m).max() < 0.04


@pytest.mark.parametrize(("iterations", "is_there"), [(1, False), (8, True)])
def test_a_motion_that_is_left_off_on_its_way_says_so(views, iterations, is_there):
    """By the sigmas of what it is said to be known by; the truth is no motion."""
    levels, level = views[10].pyramid.levels[1:], replace(FINE, iterations=iterations)
    guess = exp_se3(np.array([0.01, 0.0, 0.0, 0.03, 0.0, 0.02]))
    noise, none, nominal = DepthNoise(DepthSettings()), Correspondences.none(), ColorCalibration.nominal()
    result = icp(levels, levels, guess, none, nominal, noise, (level,))
    assert is_at_rest(result) == is_there
    assert (length_m(result.target_from_source) < 0.001) == is_there


def test_what_rounding_made_of_a_rotation_is_not_handed_on(views):
    """Nothing that shows one wall says how large it is: a view that is shrunk fits it as well, from nearer."""
    levels, noise = views[10].pyramid.levels, DepthNoise(DepthSettings())
    guess = np.diag([1.01, 1.01, 1.01, 1.0])
    result = icp(levels, levels, guess, Correspondences.none(), ColorCalibration.nominal(), noise)
    assert rotation_error(result.target_from_source[:3, :3]) < 1e-12


class Diverging(Correspondences):
    """Features that pull by far more than they know."""

    def term(self, pose, parameters):
        gradient = np.zeros(6 + N_PARAMETERS)
        gradient[3:6] = 1e4
        return ColorTerm(1e-9 * np.eye(6 + N_PARAMETERS), gradient, 8)


def test_equations_that_ask_for_kilometres_are_not_followed():
    camera = Intrinsics(320, 240, 262.5, 262.5, 159.5, 119.5)
    grids = DepthPyramid(*fine_depth(np.zeros((240, 320), np.float32), camera, max_depth_m=4.0)).levels
    nothing, start = Correspondences.none(), exp_se3(np.array([0.1, 0, 0, 0.2, 0, 0]))
    pulling = Diverging(**vars(nothing))
    with np.errstate(over="raise", invalid="raise"):
        result = icp(grids, grids, start, pulling, ColorCalibration.nominal(), DepthNoise(DepthSettings()))
    np.testing.assert_allclose(result.target_from_source, start, rtol=0, atol=1e-12)
    assert not is_at_rest(result)


@pytest.mark.parametrize("patch_px", [24, 480])
def test_where_depth_says_nothing_the_colour_camera_is_not_learnt(rng, patch_px):
    """Features see a camera of another focal length; of depth there is a small patch, or the whole wall."""
    camera = Intrinsics(640, 480, 525.0, 525.0, 319.5, 239.5)
    wall = np.zeros((480, 640), np.float32)
    wall[240 - patch_px // 2 : 240 + patch_px // 2, 320 - patch_px // 2 : 320 + patch_px // 2] = 2.0
    grids = DepthPyramid(*fine_depth(wall, camera, max_depth_m=4.0)).levels
    rays = rng.uniform(-0.4, 0.4, (80, 2))
    seen = Correspondences.at_rest(rays, np.full(80, 2.0), 1.05 * rays, np.full(80, 1.5 / 525))
    before = ColorCalibration.nominal()
    after = icp(grids, grids, np.eye(4), seen, before, DepthNoise(DepthSettings())).calibration
    assert (after is before) is (patch_px == 24)
