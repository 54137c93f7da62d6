"""Reprojection of sparse readings, against the plain formula reading by reading."""

from __future__ import annotations

from types import SimpleNamespace

import numpy as np

from razer.frame import Intrinsics
from slam.backend.view_checks.reprojection import MIN_DEPTH_M, reprojected
from slam.frontend.sparse_readings import SparseReadings
from slam.se3 import exp_se3

HERE, THERE = Intrinsics(12, 9, 10.0, 11.0, 5.5, 4.0), Intrinsics(16, 10, 14.0, 13.0, 8.0, 4.5)
THERE_FROM_HERE = exp_se3(np.array([0.05, -0.2, 0.1, 0.3, 0.1, -1.5]))


def seen(k, depth):
    black = np.zeros((*depth.shape, 3), np.uint8)
    colors = black, black[..., 0] == 0
    return SimpleNamespace(sparse=SparseReadings(depth.astype(np.float16), *colors, *colors, k))


def one_by_one(view, other, motion):
    k, to = view.sparse.intrinsics, other.sparse.intrinsics
    for row, column in np.argwhere(view.sparse.depth > 0):
        z = float(view.sparse.depth[row, column])
        point = motion @ np.array([(column - k.cx) / k.fx * z, (row - k.cy) / k.fy * z, z, 1.0])
        if point[2] <= MIN_DEPTH_M:
            continue
        u, v = np.rint(to.fx * point[0] / point[2] + to.cx), np.rint(to.fy * point[1] / point[2] + to.cy)
        if 0 <= u < to.width and 0 <= v < to.height:
            yield row * k.width + column, v * to.width + u, point[2]


def test_readings_fall_where_the_plain_formula_has_them(rng):
    depth = rng.uniform(0.5, 4, (9, 12)) * (rng.uniform(size=(9, 12)) > 0.2)  # holes, and some behind the other
    view, other = seen(HERE, depth), seen(THERE, np.ones((10, 16)))
    expected = np.array([*one_by_one(view, other, THERE_FROM_HERE)])
    here, there, z = reprojected(view, other, THERE_FROM_HERE)
    assert 10 < len(expected) < np.count_nonzero(depth)
    np.testing.assert_array_equal(np.column_stack([here, there]), expected[:, :2])
    np.testing.assert_allclose(z, expected[:, 2], rtol=1e-5)


def test_what_was_worked_out_before_is_that_of_no_other_view_or_motion(rng):
    view, other = seen(HERE, rng.uniform(0.5, 4, (9, 12))), seen(THERE, np.ones((10, 16)))
    motion = THERE_FROM_HERE.copy()
    before = reprojected(view, other, motion)
    hidden = np.arange(108).reshape(9, 12) == before[0][0]
    without = SimpleNamespace(sparse=view.sparse.without(hidden))
    np.testing.assert_array_equal(reprojected(without, other, motion)[0], before[0][1:])
    motion[:3, 3] += 0.25  # in place
    expected = np.array([*one_by_one(view, other, motion)])
    np.testing.assert_array_equal(np.column_stack(reprojected(view, other, motion)[:2]), expected[:, :2])
