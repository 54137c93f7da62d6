"""Depth images reduced to oriented points."""

from __future__ import annotations

import pickle

import numpy as np
import pytest

from razer.frame import Intrinsics
from slam.frontend.depth_pyramid import DepthPyramid, fine_depth, halved


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
            result[row, column] = read[read < 1.05 * read.min() + 0.03].mean()
    return result


def test_halving_is_that_of_each_four_pixels(rng):
    depth = rng.choice([1.0, 1.005, 1.07, 1.09, 2.0, 2.04, 3.0], (31, 45)).astype(np.float32)
    depth[rng.random(depth.shape) < 0.4] = 0
    half, _ = halved(depth, Intrinsics(45, 31, 40.0, 40.0, 22.0, 15.0))
    np.testing.assert_allclose(half, slowly_halved(depth), atol=1e-6)
    assert (half == 0).any()


CAMERA = Intrinsics(320, 240, 262.5, 262.5, 159.5, 119.5)


def side_wall(away_m):
    """The depth (H, W) of a wall that stands beside the camera, seen at an ever more grazing angle."""
    columns = np.broadcast_to(np.arange(CAMERA.width), (CAMERA.height, CAMERA.width))
    return (away_m * CAMERA.fx / np.maximum(columns - CAMERA.cx, 1e-3)).astype(np.float32)


def test_a_wall_whose_readings_fail_or_scatter_stays_where_it_is(rng):
    """As it does at a grazing angle. Holes are not the nearest readings, nor is the nearest of four the rightest."""
    wall = side_wall(0.65)
    read = wall + rng.normal(0, 0.02, wall.shape).astype(np.float32)
    read[rng.random(read.shape) < 0.3] = 0
    depth, camera = fine_depth(read, CAMERA, max_depth_m=4.0)
    columns = np.broadcast_to(np.arange(camera.width), depth.shape)
    away_m = depth * (columns - camera.cx) / camera.fx
    for near_m, far_m in ((1.2, 1.8), (1.8, 2.4), (2.4, 3.0)):
        part = away_m[(depth > near_m) & (depth < far_m)]
        assert len(part) > 500
        assert part.mean() == pytest.approx(0.65, abs=0.0015)


def test_the_rim_of_what_stands_before_a_wall_is_no_surface_in_between():
    """Where readings fail along it, too."""
    depth = np.full((240, 320), 2.0, np.float32)
    depth[:, :150] = 1.0
    depth[::2, 148:153] = 0
    fine, _ = fine_depth(depth, CAMERA, max_depth_m=4.0)
    assert set(np.unique(fine)) <= {0.0, 1.0, 2.0}


def test_holes_of_a_few_readings_are_filled_and_larger_ones_are_not():
    depth = np.full((240, 320), 2.0, np.float32)
    depth[100, 100] = 0
    depth[20:30, 200:210] = 0
    fine, _ = fine_depth(depth, CAMERA, max_depth_m=4.0)
    assert fine[50, 50] == 2.0
    assert (fine[11:14, 101:104] == 0).all()


def test_a_released_pyramid_is_smaller_and_the_same(room):
    """It is a PNG until it is asked for, which loses nothing."""
    pyramid = DepthPyramid(*fine_depth(room[10].depth, room[10].intrinsics, max_depth_m=4.0))
    depth, points, size = pyramid.depth, pyramid.levels[-1].points, pyramid.n_bytes
    for _ in range(2):
        pyramid.release()
        assert pyramid.n_bytes < 0.75 * size
        np.testing.assert_array_equal(pyramid.depth, depth)
    np.testing.assert_array_equal(pickle.loads(pickle.dumps(pyramid)).levels[-1].points, points)
