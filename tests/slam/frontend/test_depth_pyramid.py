"""Depth images reduced to oriented points."""

from __future__ import annotations

import numpy as np
import pytest

from razer.frame import Intrinsics
from slam.frontend.depth_pyramid import DepthPyramid, halved


def test_halving_takes_the_nearer_surface_and_keeps_the_camera():
    camera = Intrinsics(4, 2, 4.0, 4.0, 1.5, 0.5)
    depth = np.array([[1.0, 1.0, 2.0, 0.0], [1.0, 3.0, 0.0, 0.0]], np.float32)
    half, smaller = halved(depth, camera)
    np.testing.assert_allclose(half, [[1.0, 2.0]])
    # The ray through the middle of four pixels is the ray through the one they became.
    assert (0.5 - camera.cx) / camera.fx == pytest.approx((0 - smaller.cx) / smaller.fx)


def test_points_and_normals_of_a_slanted_plane():
    camera = Intrinsics(160, 120, 130.0, 130.0, 79.5, 59.5)
    normal = np.array([0.3, -0.2, -1.0]) / np.linalg.norm([0.3, -0.2, -1.0])
    u, v = np.meshgrid(np.arange(160), np.arange(120))
    rays = np.stack([(u - camera.cx) / camera.fx, (v - camera.cy) / camera.fy, np.ones_like(u)])
    depth = (normal @ np.array([0, 0, 2.0]) / np.tensordot(normal, rays, 1)).astype(np.float32)
    grid = DepthPyramid(depth, camera).levels[-1]
    assert grid.valid.mean() > 0.95
    np.testing.assert_allclose(grid.sample_normals.T, np.tile(normal, (grid.sample_normals.shape[1], 1)), atol=2e-3)
    assert (normal @ grid.sample_points == pytest.approx(normal[2] * 2.0, abs=1e-4)) is True


def slowly_halved(depth):
    """Pixel by pixel."""
    result = np.zeros((depth.shape[0] // 2, depth.shape[1] // 2))
    for row, column in np.ndindex(result.shape):
        four = depth[2 * row : 2 * row + 2, 2 * column : 2 * column + 2].ravel()
        read = four[four > 0].astype(float)
        if len(read):
            result[row, column] = read[read < 1.02 * read.min() + 0.01].mean()
    return result


def test_halving_is_that_of_each_four_pixels(rng):
    depth = rng.choice([1.0, 1.005, 2.0, 2.04, 3.0], (31, 45)).astype(np.float32)
    depth[rng.random(depth.shape) < 0.4] = 0
    half, _ = halved(depth, Intrinsics(45, 31, 40.0, 40.0, 22.0, 15.0))
    np.testing.assert_allclose(half, slowly_halved(depth), atol=1e-6)
    assert (half == 0).any()
