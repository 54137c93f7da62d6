"""Regions: a half space, and what a lasso on a picture holds."""

from __future__ import annotations

import numpy as np
import pytest

from razer.edits.region import Region, inside_polygon

SQUARE = [(-0.5, -0.5), (0.5, -0.5), (0.5, 0.5), (-0.5, 0.5)]
# A camera at the origin that looks along -z, as WebGL has it: x' = x / -z.
PERSPECTIVE = [1.0, 0, 0, 0, 0, 1.0, 0, 0, 0, 0, -1.0, -0.2, 0, 0, -1.0, 0]


def test_a_plane_holds_the_side_where_its_normal_points():
    region = Region.model_validate({"plane": {"normal": [0, 0, 2], "offset_m": 1.0}})
    assert region.holds(np.array([[9.0, 9, 0.49], [9, 9, 0.5], [9, 9, 3]])).tolist() == [False, True, True]


def test_a_lasso_holds_what_is_drawn_around_in_front_of_the_camera():
    region = Region.model_validate({"lasso": {"clip_from_world": PERSPECTIVE, "polygon": SQUARE}})
    points = np.array([[0.0, 0, -2], [0.9, 0, -2], [1.1, 0, -2], [0, 1.1, -2], [0.4, 0.4, -1], [0, 0, 2], [0, 0, 0]])
    assert region.holds(points).tolist() == [True, True, False, False, True, False, False]


def test_a_polygon_that_folds_back_holds_by_the_even_odd_rule():
    # A C that opens to the right; its mouth is outside.
    c = np.array([(0, 0), (3, 0), (3, 1), (1, 1), (1, 2), (3, 2), (3, 3), (0, 3)], float)
    points = np.array([[0.5, 1.5], [2.0, 1.5], [2.0, 0.5], [2.0, 2.5], [4.0, 0.5], [-1, 1.5]])
    assert inside_polygon(points, c).tolist() == [True, False, True, True, False, False]


@pytest.mark.parametrize("seed", range(5))
def test_inside_a_convex_polygon_is_on_one_side_of_all_its_edges(seed):
    rng = np.random.default_rng(seed)
    angles = np.sort(rng.uniform(0, 2 * np.pi, 7))
    polygon = np.stack([np.cos(angles), np.sin(angles)], axis=1) + rng.normal(size=2)
    points = rng.uniform(-2, 2, (400, 2)) + polygon.mean(axis=0)
    edges = np.roll(polygon, -1, axis=0) - polygon
    to_point = points[:, None] - polygon
    left = edges[:, 0] * to_point[..., 1] - edges[:, 1] * to_point[..., 0] > 0
    np.testing.assert_array_equal(inside_polygon(points, polygon), left.all(axis=1))
    np.testing.assert_array_equal(inside_polygon(points, polygon[::-1]), left.all(axis=1))
