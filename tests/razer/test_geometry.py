"""Rigid transforms and the pinhole camera: what undoes what."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.testing import assert_allclose
from scipy.spatial.transform import Rotation

from razer.geometry import back_project, inverse, is_rigid, nearest_rotation, project, rotation_error, transform_points
from tests.support.scenes import pose

MATRIX = np.array([[500.0, 0, 320], [0, 480, 240], [0, 0, 1]])


@pytest.mark.parametrize("seed", range(5))
def test_inverse_and_composition(seed: int) -> None:
    rng = np.random.default_rng(seed)
    a_from_b, b_from_c = (pose(rng.normal(0, 10, 3), rng.uniform(-180, 180, 3)) for _ in range(2))
    points = rng.normal(0, 5, (4, 6, 3))
    assert_allclose(inverse(a_from_b) @ a_from_b, np.eye(4), atol=1e-12)
    assert_allclose(
        transform_points(a_from_b, transform_points(b_from_c, points)),
        transform_points(a_from_b @ b_from_c, points),
        atol=1e-10,
    )
    assert_allclose(transform_points(inverse(a_from_b), transform_points(a_from_b, points)), points, atol=1e-10)


def test_a_point_by_hand() -> None:
    quarter_turn_about_z = pose((1, 2, 3), (0, 0, 90))
    assert_allclose(transform_points(quarter_turn_about_z, np.array([1.0, 0, 0])), [1, 3, 3], atol=1e-12)
    assert transform_points(quarter_turn_about_z, np.zeros((0, 3))).shape == (0, 3)


@pytest.mark.parametrize(
    ("matrix", "rigid"),
    [
        (pose((1e6, 0, 0), (10, 20, 30)), True),
        (np.diag([1.0, 1, -1, 1]), False),  # a mirror
        (np.diag([2.0, 2, 2, 1]), False),
        (np.diag([1.0, 1, 1, 2]), False),
        (np.zeros((4, 4)), False),
        (np.full((4, 4), np.nan), False),
        (np.eye(3), False),
        (pose((np.inf, 0, 0)), False),
    ],
)
def test_what_is_rigid(matrix: np.ndarray, rigid: bool) -> None:
    assert is_rigid(matrix) is rigid


def test_rotation_error_is_the_largest_entry_of_r_transposed_r_less_one() -> None:
    assert rotation_error(np.diag([1.0, 1.1, 1.0])) == pytest.approx(0.21)
    assert rotation_error(pose(turn_deg=(10, 20, 30))[:3, :3]) == pytest.approx(0, abs=1e-12)


@pytest.mark.parametrize("seed", range(5))
def test_nearest_rotation_is_nearer_than_any_other(seed: int) -> None:
    rng = np.random.default_rng(seed)
    matrix = pose(turn_deg=rng.uniform(-180, 180, 3))[:3, :3] + rng.normal(0, 0.2, (3, 3))
    nearest = nearest_rotation(matrix)
    assert rotation_error(nearest) < 1e-12
    assert np.linalg.det(nearest) == pytest.approx(1)
    around = Rotation.from_rotvec(rng.normal(0, 0.1, (50, 3))).as_matrix() @ nearest
    anywhere = Rotation.random(50, random_state=seed).as_matrix()
    gaps = np.linalg.norm(np.concatenate([around, anywhere]) - matrix, axis=(1, 2))
    assert np.linalg.norm(nearest - matrix) <= gaps.min()


def test_nearest_rotation_of_a_mirror_is_still_a_rotation() -> None:
    assert np.linalg.det(nearest_rotation(np.diag([1.0, 1, -0.9]))) == pytest.approx(1)


def test_projection_undoes_back_projection() -> None:
    rng = np.random.default_rng(0)
    u, v, depth_m = rng.uniform(0, 640, 50), rng.uniform(0, 480, 50), rng.uniform(0.1, 5, 50)
    points = back_project(u, v, depth_m, MATRIX)
    for found, expected in zip(project(points, MATRIX), (u, v, depth_m), strict=True):
        assert_allclose(found, expected, atol=1e-9)


def test_the_axes_of_the_camera() -> None:
    assert_allclose(back_project(np.array([320]), np.array([240]), np.array([2.0]), MATRIX), [[0, 0, 2]])
    assert_allclose(back_project(np.array([820]), np.array([240]), np.array([2.0]), MATRIX), [[2, 0, 2]])
    assert_allclose(back_project(np.array([320]), np.array([720]), np.array([2.0]), MATRIX), [[0, 2, 2]])


@pytest.mark.filterwarnings("error")
def test_points_beside_and_behind_the_camera_have_no_pixel() -> None:
    u, v, z = project(np.array([[1.0, 1, 0], [1, 1, -1], [0, 0, 1]]), MATRIX)
    assert np.isnan(u).tolist() == np.isnan(v).tolist() == [True, True, False]
    assert_allclose(z, [0, -1, 1])
