"""Equations of depth against a loop over points, and what is told of their fit."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from razer.frame import Intrinsics
from slam.config import DepthSettings
from slam.frontend.depth_noise import DepthNoise
from slam.frontend.depth_pyramid import surface_grid
from slam.frontend.gauss_newton.depth_term import CHANCE, HUBER, MIN_MATCHED, TUKEY, DepthTerm
from slam.se3 import exp_se3

CAMERA = Intrinsics(40, 30, 33.0, 33.0, 19.5, 14.5)
NOISE = DepthNoise(DepthSettings())
REACH_M = 0.05
OFF = exp_se3(np.array([0.004, -0.006, 0.005, 0.1, -0.006, 0.008]))


@pytest.fixture(scope="module")
def grids():
    """A bowl with a step, seen twice under noise of its own: something has moved, and some of it is read once only."""
    rng = np.random.default_rng(3)
    row, column = np.mgrid[:30, :40]
    depth = 1.5 - 0.0006 * (column - 15.0) ** 2 - 0.0009 * (row - 18.0) ** 2 + 0.3 * (column > 30)
    moved = 0.1 * ((abs(row - 8) < 4) & (abs(column - 9) < 5))
    return [
        surface_grid((each + rng.normal(0, 0.002, depth.shape)).astype(np.float32), CAMERA)
        for each in (depth - moved, np.where((abs(row - 22) < 2) & (abs(column - 20) < 3), 0, depth))
    ]


def by_loop(source, target, pose, strict, reach_m=REACH_M):
    """Information, gradient, the same with the source's own normals on one side, weights and residuals."""
    information, gradient, in_common = np.zeros((6, 6)), np.zeros(6), np.zeros((6, 6))
    told, n_inside, n_read = [], 0, 0
    for point, own_normal in zip(source.sample_points.T.astype(float), source.sample_normals.T, strict=True):
        p = pose[:3, :3] @ point + pose[:3, 3]
        u = round(p[0] / p[2] * CAMERA.fx + CAMERA.cx)
        v = round(p[1] / p[2] * CAMERA.fy + CAMERA.cy)
        if not (0 <= u < CAMERA.width and 0 <= v < CAMERA.height):
            continue
        n_inside += 1
        pixel = v * CAMERA.width + u
        if not target.valid[pixel]:
            continue
        n_read += 1
        q, n = target.points[:, pixel].astype(float), target.normals[:, pixel].astype(float)
        own = pose[:3, :3] @ own_normal
        distance = float(n @ (q - p))
        if np.linalg.norm(q - p) >= 2 * reach_m or abs(distance) >= reach_m or own @ n <= 0.8:
            continue
        sigma = float(NOISE.sigma(np.array([p[2]], np.float32), np.array([distance], np.float32))[0])
        r = distance / sigma
        weight = max(0.0, 1 - (r / TUKEY) ** 2) ** 2 if strict else min(1.0, HUBER / max(abs(r), 1e-6))
        j, of_own = (np.concatenate([np.cross(p, each), each]) / sigma for each in (n, own))
        information += weight * np.outer(j, j)
        gradient += weight * r * j
        in_common += weight * np.outer(j, of_own)
        told.append((r, weight))
    return information, gradient, in_common, np.array(told), n_inside, n_read


def moved(x, y):
    return exp_se3(np.array([0.004, -0.006, 0.005, x, y, 0.008]))


@pytest.mark.parametrize(
    ("pose", "reach_m", "strict"),
    [
        (OFF, REACH_M, True),
        (OFF, REACH_M, False),
        (OFF, 0.015, False),  # less than what half a pixel spans
        (moved(-0.15, 0.12), REACH_M, False),
        (moved(0.12, -0.15), REACH_M, False),
    ],
)
def test_equations_and_figures_are_those_of_a_loop_over_points(grids, pose, reach_m, strict):
    source, target = grids
    information, gradient, in_common, told, n_inside, n_read = by_loop(source, target, pose, strict, reach_m)
    term = DepthTerm.of(source, target, pose, NOISE, reach_m, strict)
    r, weight = told.T
    assert 100 < len(r) < n_read < n_inside < source.sample_points.shape[1]
    assert term.is_enough
    assert len(term.residuals) == len(r)
    np.testing.assert_allclose(term.equations[0], information, rtol=1e-3, atol=1e-5 * np.abs(information).max())
    np.testing.assert_allclose(term.equations[1], gradient, rtol=1e-3, atol=1e-4 * np.abs(gradient).max())
    assert term.overlap == pytest.approx(n_inside / source.sample_points.shape[1])
    assert term.agreement == pytest.approx(len(r) / n_read)
    assert term.rms == pytest.approx(np.sqrt((weight * r**2).sum() / weight.sum()), rel=1e-3)
    tukey = np.maximum(0, 1 - (r / TUKEY) ** 2) ** 2
    assert term.fit == pytest.approx(term.overlap * tukey.sum() / n_read, rel=1e-3)
    shape = in_common - CHANCE / np.sqrt(len(r)) * (information - in_common) if strict else information
    np.testing.assert_allclose(term.shape_information, shape, rtol=1e-3, atol=1e-4 * np.abs(information).max())


def test_where_normals_of_both_views_are_the_same_all_information_is_shape(grids):
    term = DepthTerm.of(grids[0], grids[0], np.eye(4), NOISE, REACH_M, strict=True)
    np.testing.assert_allclose(term.shape_information, term.equations[0], rtol=1e-4, atol=1.0)
    assert term.rms == 0
    assert term.fit == pytest.approx(term.overlap)


@pytest.mark.parametrize(("n_points", "is_enough"), [(MIN_MATCHED - 1, False), (MIN_MATCHED, True)])
def test_so_many_points_must_be_matched(grids, n_points, is_enough):
    source = grids[0]
    some = replace(
        source, sample_points=source.sample_points[:, :n_points], sample_normals=source.sample_normals[:, :n_points]
    )
    term = DepthTerm.of(some, source, np.eye(4), NOISE, REACH_M, strict=True)
    assert len(term.residuals) == n_points
    assert term.is_enough == is_enough == bool(np.any(term.equations[0]))


def test_few_points_that_are_matched_say_nothing(grids):
    source, target = grids
    far = exp_se3(np.array([0, 0, 0, 0, 0, 3.0]))
    term = DepthTerm.of(source, target, far, NOISE, REACH_M, strict=True)
    assert not term.is_enough
    assert not np.any(term.equations[0])
    assert not np.any(term.equations[1])
    assert not np.any(term.shape_information)
    assert (term.fit, term.rms) == (0.0, float("inf"))


@pytest.mark.parametrize(("slant_deg", "agreement"), [(45, 1.0), (70, 0.0)])
def test_points_farther_apart_than_twice_the_reach_are_not_matched(slant_deg, agreement):
    """A plane moved by 4 cm along its normal: along rays that graze it that is 12 cm, though it lies 4 cm off."""
    camera = Intrinsics(40, 30, 330.0, 330.0, 19.5, 14.5)
    slant = np.radians(slant_deg)
    normal = np.array([0.0, np.sin(slant), -np.cos(slant)])
    down = (np.arange(30) - camera.cy) / camera.fy
    depth = 1.5 * normal[2] / (down * normal[1] + normal[2])
    grid = surface_grid(np.repeat(depth[:, None], 40, axis=1).astype(np.float32), camera)
    pose = exp_se3(np.concatenate([np.zeros(3), 0.04 * normal]))
    term = DepthTerm.of(grid, grid, pose, NOISE, REACH_M, strict=False)
    assert term.overlap > 0.5
    assert term.agreement == pytest.approx(agreement, abs=0.05)


def test_what_lies_behind_the_camera_is_not_projected(grids):
    source, target = grids
    behind = exp_se3(np.array([0, 0, 0, 0, 0, -3.0]))
    assert DepthTerm.of(source, target, behind, NOISE, REACH_M, strict=True).overlap == 0.0
