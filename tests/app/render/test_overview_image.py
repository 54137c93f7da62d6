"""The overview image of a map stands upright and shows every instance in its colour."""

from __future__ import annotations

import numpy as np
import pytest

from app.render.overview_image import overview_image
from app.render.palette import instance_colors
from razer.mesh.labelled_mesh import LabelledMesh


def plate(height_m, size_m, instance, first):
    """A square facing +z, as two triangles."""
    corners = np.array([[-1, -1], [1, -1], [1, 1], [-1, 1]]) * size_m / 2
    vertices = np.column_stack([corners, np.full(4, height_m)]).astype(np.float32)
    return vertices, np.full(4, instance, np.int32), np.array([[0, 1, 2], [0, 2, 3]], np.int32) + first


@pytest.mark.parametrize("flip", [1.0, -1.0])
def test_what_is_higher_in_the_world_is_higher_in_the_image(flip):
    floor, lamp = plate(0.0, 4.0, 3, 0), plate(2.0, 0.5, 8, 4)
    turned = np.diag([1.0, flip, flip])  # the same room in a world whose z points down
    vertices = (np.concatenate([floor[0], lamp[0]]) @ turned).astype(np.float32)
    mesh = LabelledMesh(
        vertices,
        np.full((8, 3), 200, np.uint8),
        np.concatenate([floor[1], lamp[1]]),
        np.concatenate([floor[2], lamp[2]]),
    )
    image = overview_image(mesh, np.array([0.0, 0.0, flip]), 400, 300)
    assert image.shape == (300, 400, 3)
    right = image[:, 200:].astype(float)
    hues = [color / np.linalg.norm(color) for color in instance_colors(np.array([3, 8])).astype(float)]
    length = np.linalg.norm(right, axis=2)
    rows = [np.nonzero((right @ hue > 0.999 * length) & (length < 400))[0] for hue in hues]
    assert len(rows[0]) > 1000
    assert len(rows[1]) > 20
    assert rows[1].mean() < rows[0].mean()
