"""Grids of light samples over faces."""

from __future__ import annotations

import numpy as np
import pytest

from data_tools.synthetic.light.face_grid import SPACING_M, FaceGrid
from data_tools.synthetic.objects.catalogue import PIECES
from data_tools.synthetic.shapes.primitives import block
from data_tools.synthetic.shapes.thing import tinted

GREY = tinted("smooth", (200.0, 200.0, 200.0))


def quads_of(*names: str) -> np.ndarray:
    rng = np.random.default_rng(3)
    return np.concatenate([solid.quads for name in names for solid in PIECES[name](rng).solids])


def test_every_node_is_found_again_at_its_own_place() -> None:
    quads = block(1.0, 2.0, 0.5, (1.3, 0.6, 0.4), GREY).quads
    grid = FaceGrid.over(quads)
    nodes = np.arange(len(grid.face))
    np.testing.assert_array_equal(grid.nearest_node(grid.face, grid.points(quads).astype(np.float32)), nodes)
    assert grid.counts.min() >= 2
    steps = np.linalg.norm(grid.gradient, axis=2)
    assert (steps >= 1 / SPACING_M - 1e-6).all()


@pytest.mark.parametrize("names", [("chair", "bottle", "plant"), ("couch", "toilet", "guitar")])
def test_nodes_lie_on_their_faces_and_within_them(names: tuple[str, ...]) -> None:
    quads = quads_of(*names)
    grid = FaceGrid.over(quads)
    points, face = grid.points(quads), grid.face
    height = np.einsum("nk,nk->n", points - quads[face, 0], grid.normals[face])
    assert np.ptp(height) < 1e-6
    assert 0 < height[0] < 0.005
    for corner in range(4):
        start, end = quads[face, corner], quads[face, (corner + 1) % 4]
        inwards = np.cross(grid.normals[face], end - start)
        assert (np.einsum("nk,nk->n", points - start, inwards) > -1e-7).all()


def test_grids_do_not_share_pixels_and_their_rims_are_repeated() -> None:
    quads = quads_of("office chair", "cup", "table")
    grid = FaceGrid.over(quads)
    values = np.arange(1, len(grid.face) + 1, dtype=np.float32)[:, None]
    image = grid.image(values)[..., 0]
    x, y = (grid.place[grid.face] + grid.cell()).T
    np.testing.assert_array_equal(image[y, x], values[:, 0])
    assert (image > 0).sum() == ((grid.counts + 2).prod(axis=1)).sum()
    left, top = grid.place[0]
    np.testing.assert_array_equal(
        image[top : top + grid.counts[0, 1], left - 1], image[top : top + grid.counts[0, 1], left]
    )


def test_corners_of_a_face_are_the_ends_of_its_grid() -> None:
    quads = block(0.0, 0.0, 0.0, (0.8, 0.5, 0.3), GREY).quads
    grid = FaceGrid.over(quads)
    places = np.einsum("fak,fck->fca", grid.gradient, quads) + grid.origin[:, None]
    np.testing.assert_allclose(places.min(axis=1), 0, atol=1e-9)
    np.testing.assert_allclose(places.max(axis=1), grid.counts - 1, atol=1e-9)
