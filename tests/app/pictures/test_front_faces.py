"""What a camera sees of triangles, beside rays that try each of them."""

from __future__ import annotations

import numpy as np
import pytest

from app.pictures.camera import axes_towards, fitted_camera
from app.pictures.front_faces import FrontFaces
from razer.mesh.labelled_mesh import LabelledMesh

UP, HEADING = np.array([0.0, 0.0, 1.0]), np.array([0.6, 0.8, 0.0])
SIZE = (60, 44)


def soup(n: int = 120) -> LabelledMesh:
    """Triangles of a few decimetres at random."""
    rng = np.random.default_rng(4)
    corners = rng.uniform(-1, 1, (n, 1, 3)) + rng.normal(scale=0.2, size=(n, 3, 3))
    vertices = corners.reshape(-1, 3).astype(np.float32)
    colors, labels = np.zeros((3 * n, 3), np.uint8), np.repeat(np.arange(1, n + 1, dtype=np.int32), 3)
    return LabelledMesh(vertices, colors, labels, np.arange(3 * n, dtype=np.int32).reshape(-1, 3))


def met(faces: FrontFaces, mesh: LabelledMesh, x: float, y: float) -> tuple[int, np.ndarray, float, float]:
    """Row of the triangle that the ray through a place of the image meets first, -1 for none; its weights; how far away
    it is; and how near the ray comes to an edge of any, as a weight."""
    camera = faces.camera
    slope = (np.array([x, y]) - camera.center_px) / camera.focal_px
    right, down, forward = camera.axes
    aside = slope[0] * right + slope[1] * down
    if camera.is_orthographic:
        origin, direction = camera.eye + aside, forward
    else:
        origin, direction = camera.eye, (aside + forward) / np.linalg.norm(aside + forward)
    best, edge = (-1, np.zeros(3), np.inf), np.inf
    for row, triangle in enumerate(faces.triangles):
        a, b, c = mesh.vertices[triangle].astype(float)
        system = np.stack([a - c, b - c, -direction], axis=1)
        u, v, distance = np.linalg.solve(system, origin - c)
        weights = np.array([u, v, 1 - u - v])
        edge = min(edge, np.abs(weights).min()) if weights.min() > -0.1 else edge
        if weights.min() >= 0 and 0 < distance < best[2]:
            best = row, weights, distance
    return *best, edge


@pytest.mark.parametrize("is_orthographic", [False, True])
def test_each_pixel_shows_what_the_ray_through_its_middle_meets_first(is_orthographic):
    mesh = soup()
    axes = axes_towards(UP, HEADING, 40.0)
    camera = fitted_camera(axes, mesh.vertices, SIZE, 3, is_orthographic=is_orthographic)
    faces = FrontFaces(mesh, camera)
    assert 0 < len(faces.triangles) < len(mesh.triangles)
    first, last = 10, 30
    seen = faces.seen(first, last)
    order = np.cumsum(seen.covered.ravel()).reshape(seen.covered.shape) - 1
    compared = 0
    for row in range(first, last):
        for column in range(0, SIZE[0], 2):
            found, weights, distance, edge = met(faces, mesh, column + 0.5, row + 0.5)
            if edge < 0.02:  # either side of an edge will do
                continue
            compared += 1
            at = row - first, column
            assert seen.covered[at] == (found >= 0)
            if found >= 0:
                assert seen.corners[order[at]].tolist() == faces.triangles[found].tolist()
                np.testing.assert_allclose(seen.weights[order[at]], weights, atol=5e-3)
                if not is_orthographic:
                    np.testing.assert_allclose(seen.distance[at], distance, rtol=1e-3)
    assert compared > 100


def test_numbers_of_triangles_are_exact_beyond_one_digit():
    n = 5000  # more than 4096, side by side on a grid, seen from straight above
    middle = np.stack(np.divmod(np.arange(n), 100), axis=1)
    corners = middle[:, None] + np.array([[-0.45, -0.45], [0.45, -0.45], [0.0, 0.45]])
    vertices = np.concatenate([corners, np.zeros((n, 3, 1))], axis=2).reshape(-1, 3).astype(np.float32)
    triangles = np.arange(3 * n, dtype=np.int32).reshape(-1, 3)
    mesh = LabelledMesh(vertices, np.zeros_like(vertices, np.uint8), np.repeat(np.arange(n), 3), triangles)
    camera = fitted_camera(axes_towards(UP, HEADING, 90.0), vertices, (900, 700), 5, is_orthographic=True)
    seen = FrontFaces(mesh, camera).seen(0, 700)
    shown = np.unique(seen.corners, axis=0)
    assert len(shown) > 0.99 * n  # a few at the rim are outside
    points = (vertices[seen.corners] * seen.weights[:, :, None]).sum(axis=1)
    rows, columns = np.nonzero(seen.covered)
    expected = np.stack([columns + 0.5, rows + 0.5], axis=1)
    np.testing.assert_allclose(camera.project(points), expected, atol=0.1)
