"""Light that falls on faces, against closed forms."""

from __future__ import annotations

import numpy as np
import pytest

from data_tools.synthetic.light.emitters import ceiling_glow
from data_tools.synthetic.light.face_grid import FaceGrid
from data_tools.synthetic.light.radiosity import Surroundings, gathered, irradiance
from data_tools.synthetic.rendering.ray_renderer import scene_of
from data_tools.synthetic.shapes.primitives import block
from data_tools.synthetic.shapes.solids import Solid
from data_tools.synthetic.shapes.thing import Thing, tinted

GREY = tinted("smooth", (200.0, 200.0, 200.0))


def sampled(*solids: Solid) -> tuple[FaceGrid, np.ndarray, Surroundings]:
    """The grid, the nodes' places and what they see, of a world of these solids."""
    quads = np.concatenate([solid.quads for solid in solids])
    grid = FaceGrid.over(quads)
    return grid, grid.points(quads), Surroundings.of(grid, quads, scene_of({1: Thing("box", solids)}))


def inside_out(solid: Solid) -> Solid:
    return Solid(solid.quads[:, ::-1].copy(), solid.uv[:, ::-1].copy(), solid.material)


def test_in_a_furnace_light_is_the_sum_of_its_bounces() -> None:
    grid, _, around = sampled(inside_out(block(0, 0, 0, (1, 1, 1), GREY)))
    emitted = np.full((len(grid.face), 3), 0.7, np.float32)
    light = irradiance(around, emitted, np.full_like(emitted, 0.5), (9.0, 9.0, 9.0))
    # Light that was sent back up to three times.
    known = 0.7 * (1 + 0.5 + 0.25 + 0.125)
    # At the edges rays stop on a wall that is so near that they do not count.
    np.testing.assert_allclose(light, known, rtol=1e-5)


def test_an_open_plane_sees_the_whole_sky_and_the_foot_of_a_wall_half_of_it() -> None:
    floor, wall = block(5, 0, -0.1, (10, 20, 0.1), GREY), block(-0.05, 0, 0, (0.1, 20, 10), GREY)
    grid, points, around = sampled(floor, wall)
    black = np.zeros((len(grid.face), 3), np.float32)
    light = gathered(around, black, (1.0, 1.0, 1.0))[:, 0]
    up = (grid.normals[grid.face, 2] > 0.99) & (points[:, 2] < 0.05) & (np.abs(points[:, 1]) < 2)
    near, far = up & (points[:, 0] < 0.5), up & (points[:, 0] > 9.5)
    assert near.sum() > 10

    # What a strip of width w before a wall of height h sees of it: (1 - x / sqrt(x^2 + h^2)) / 2.
    def seen(x: np.ndarray) -> np.ndarray:
        return 1 - (1 - x / np.hypot(x, 10)) / 2

    assert light[near].mean() == pytest.approx(seen(points[near, 0]).mean(), abs=0.03)
    assert light[far].mean() == pytest.approx(seen(points[far, 0]).mean(), abs=0.06)


def test_a_floor_is_darker_the_nearer_to_a_box_on_it() -> None:
    floor, box = block(0, 0, -0.1, (4, 4, 0.1), GREY), block(0, 0, 0, (0.6, 0.6, 0.6), GREY)
    grid, points, around = sampled(floor, box)
    light = gathered(around, np.zeros((len(grid.face), 3), np.float32), (1.0, 1.0, 1.0))[:, 0]
    up = (grid.normals[grid.face, 2] > 0.99) & (points[:, 2] < 0.05) & (np.abs(points[:, 1]) < 0.2)
    means = [
        light[up & (points[:, 0] > a) & (points[:, 0] < b)].mean() for a, b in ((0.32, 0.42), (0.5, 0.7), (1, 1.9))
    ]
    assert means[0] < means[1] - 0.08 < means[2] - 0.12
    under = up & (np.abs(points[:, 0]) < 0.25)
    assert around.buried[under].all()
    assert not around.buried[up & (np.abs(points[:, 0]) > 0.35)].any()


def test_lights_of_a_ceiling_are_spread_evenly() -> None:
    x = np.linspace(0, 9.6, 97)
    glow = ceiling_glow(np.column_stack([x, np.full(97, 1.0), np.full(97, 2.6)]), np.zeros(2), np.array([9.6, 2.0]))
    peaks = x[1:-1][(glow[1:-1] > glow[:-2]) & (glow[1:-1] > glow[2:])]
    np.testing.assert_allclose(peaks, [1.6, 4.8, 8.0], atol=0.11)
