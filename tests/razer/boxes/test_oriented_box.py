"""Moments against numpy on all points at once; boxes against hand-made cases and rigid motions."""

from __future__ import annotations

from itertools import product

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays
from numpy.testing import assert_allclose

from razer.boxes.oriented_box import OrientedBox, PointMoments
from tests.support.scenes import axis_box, moved, pose, random_box

POINTS = arrays(np.float64, st.tuples(st.integers(1, 30), st.just(3)), elements=st.floats(-10, 10, width=32))


@given(parts=st.lists(POINTS, min_size=2, max_size=5))
@settings(deadline=None, max_examples=60)
def test_sum_of_moments_is_moments_of_all_points(parts: list[np.ndarray]) -> None:
    total = PointMoments.of(parts[0])
    for part in parts[1:]:
        total = total + PointMoments.of(part)
    points = np.concatenate(parts)
    assert total.count == len(points)
    assert_allclose(total.mean, points.mean(axis=0), atol=1e-9)
    assert_allclose(total.scatter, (points - points.mean(axis=0)).T @ (points - points.mean(axis=0)), atol=1e-6)
    if len(points) > 1:
        assert_allclose(total.covariance, np.cov(points.T), atol=1e-7)


def test_moments_add_up_exactly_far_from_the_origin() -> None:
    # The naive sum of squares loses all digits of the scatter here.
    rng = np.random.default_rng(0)
    points = rng.normal(0, 0.01, (400, 3)) + 1e6
    parts = [PointMoments.of(part) for part in np.split(points, 4)]
    total = parts[0] + parts[1] + parts[2] + parts[3]
    assert_allclose(total.covariance, np.cov(points.T), rtol=1e-3, atol=1e-7)


def test_covariance_of_one_point_is_zero() -> None:
    assert_allclose(PointMoments.of(np.array([[1.0, 2, 3]])).covariance, np.zeros((3, 3)))


@given(points=POINTS)
@settings(deadline=None, max_examples=60)
def test_axes_are_a_right_handed_frame_by_decreasing_spread(points: np.ndarray) -> None:
    moments = PointMoments.of(points)
    axes = moments.axes
    assert_allclose(axes.T @ axes, np.eye(3), atol=1e-9)
    assert np.linalg.det(axes) == pytest.approx(1.0)
    spread = np.diag(axes.T @ moments.covariance @ axes)
    assert (np.diff(spread) <= 1e-9 * max(1.0, spread[0])).all()


@pytest.mark.parametrize(
    "points",
    [np.full((5, 3), 2.0), np.linspace(0, 1, 7)[:, None] * np.array([1.0, -2, 0.5])],
    ids=["one place", "a line"],
)
def test_axes_and_box_of_degenerate_points_are_sound(points: np.ndarray) -> None:
    axes = PointMoments.of(points).axes
    assert np.linalg.det(axes) == pytest.approx(1.0)
    box = OrientedBox.around(points, axes)
    assert box.contains(points, 1e-9).all()
    assert box.volume == pytest.approx(0.0, abs=1e-12)


def anisotropic_points(seed: int) -> np.ndarray:
    rng = np.random.default_rng(seed)
    return rng.uniform(-1, 1, (200, 3)) * (1.0, 0.5, 0.2) + rng.uniform(-2, 2, 3)


@pytest.mark.parametrize("seed", range(8))
def test_box_holds_all_points_and_each_face_touches_one(seed: int) -> None:
    points = anisotropic_points(seed)
    box = OrientedBox.around(points, PointMoments.of(points).axes)
    assert box.contains(points, 1e-12).all()
    local = (points - box.center) @ box.rotation
    assert_allclose(local.max(axis=0), box.extent / 2, atol=1e-9)
    assert_allclose(local.min(axis=0), -box.extent / 2, atol=1e-9)


@pytest.mark.parametrize("seed", range(8))
def test_box_moves_with_its_points(seed: int) -> None:
    points = anisotropic_points(seed)
    world_from_here = pose((0.3, -2, 1), (20 * seed, -35, 110))
    there = points @ world_from_here[:3, :3].T + world_from_here[:3, 3]
    box = OrientedBox.around(points, PointMoments.of(points).axes)
    box_there = OrientedBox.around(there, PointMoments.of(there).axes)
    assert_allclose(box_there.extent, box.extent, atol=1e-9)
    assert_allclose(box_there.center, moved(box, world_from_here).center, atol=1e-9)
    expected, found = moved(box, world_from_here).corners(), box_there.corners()
    gaps = np.linalg.norm(expected[:, None] - found[None], axis=2).min(axis=1)
    assert gaps.max() < 1e-6


def test_trim_leaves_out_the_same_share_at_either_end() -> None:
    points = np.zeros((101, 3))
    points[:, 0] = np.arange(101) / 100
    points[0, 0], points[100, 0] = -50, 80
    box = OrientedBox.around(points, np.eye(3), trim=0.1)
    assert_allclose(box.extent, [0.8, 0, 0], atol=1e-12)
    assert_allclose(box.center, [0.5, 0, 0], atol=1e-12)


def test_corners_of_a_turned_box() -> None:
    quarter_turn = pose(turn_deg=(0, 0, 90))[:3, :3]
    corners = OrientedBox(np.array([1.0, 2, 3]), quarter_turn, np.array([2.0, 4, 6])).corners()
    expected = [(1 + 2 * x, 2 + y, 3 + 3 * z) for x, y, z in product((-1, 1), repeat=3)]
    assert sorted(map(tuple, np.rint(corners).tolist())) == sorted(expected)
    assert_allclose(corners, np.rint(corners), atol=1e-12)


@pytest.mark.parametrize("seed", range(5))
def test_enclosing_bounds_are_those_of_the_corners(seed: int) -> None:
    box = random_box(np.random.default_rng(seed))
    corners = box.corners()
    assert_allclose(box.enclosing_bounds(), [*corners.min(axis=0), *corners.max(axis=0)], atol=1e-12)
    assert_allclose(box.enclosing_bounds(0.1), [*corners.min(axis=0) - 0.1, *corners.max(axis=0) + 0.1], atol=1e-12)


def test_contains_and_grown_on_a_turned_box() -> None:
    box = OrientedBox(np.array([1.0, 0, 0]), pose(turn_deg=(0, 0, 45))[:3, :3], np.array([2.0, 2, 2]))
    reach = np.sqrt(2)  # of the square's corner along x
    points = np.array([[1 + reach - 0.01, 0, 0], [1 + reach + 0.01, 0, 0], [1.9, 0.9, 0], [1, 0, 1.05]])
    assert box.contains(points).tolist() == [True, False, False, False]
    assert box.contains(points, 0.1).tolist() == [True, True, False, True]
    assert box.grown(0.1).contains(points).tolist() == [True, True, False, True]
    assert_allclose(box.grown(0.1).extent, [2.2, 2.2, 2.2])


@pytest.mark.parametrize(
    ("center", "extent"), [((np.nan, 0, 0), (1, 1, 1)), ((0, 0, 0), (1, np.inf, 1)), ((0, 0, 0), (1, -0.1, 1))]
)
def test_impossible_boxes_are_refused(center: tuple, extent: tuple) -> None:
    with pytest.raises(ValueError, match="no box has center"):
        axis_box(center, extent)
