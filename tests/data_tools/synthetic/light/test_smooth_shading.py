"""Light over the edges of faces: no step where they are blunt, untouched where they are sharp."""

from __future__ import annotations

import numpy as np
import pytest

from data_tools.synthetic.light.face_grid import FaceGrid
from data_tools.synthetic.light.smooth_shading import smoothed_over_edges
from data_tools.synthetic.shapes.primitives import block, cylinder, rounded, soft_box
from data_tools.synthetic.shapes.solids import Solid, lathe, quad_normals
from data_tools.synthetic.shapes.thing import tinted

GREY = tinted("smooth", (200.0, 200.0, 200.0))
ROUND = {
    "cylinder": cylinder(0.3, 0, 0.5, GREY, 16),
    "cushion": soft_box((0, 0, 0), (0.6, 0.5, 0.2), (0.05, 0.05, 0.05), GREY),
    "arm": rounded((0, 0, 0), (0.2, 0.8, 0.5), "y", 0.05, GREY),
    "bowl": lathe([(0, 0), (0.1, 0), (0.2, 0.1), (0.25, 0.25), (0, 0.25)], GREY, sides=12),
}


def by_direction(grid: FaceGrid) -> np.ndarray:
    """Light as each face is turned to a lamp, the same on all its nodes."""
    facing = (grid.normals @ np.array([0.6, 0.5, 0.62])).clip(0) + 0.2
    return np.repeat(facing[grid.face, None], 3, axis=1).astype(np.float32)


def at_corners(grid: FaceGrid, quads: np.ndarray, light: np.ndarray) -> np.ndarray:
    """The light (F, 4) on the node nearest to each corner."""
    face = np.repeat(np.arange(len(quads)), 4)
    return light[grid.nearest_node(face, quads.reshape(-1, 3).astype(np.float32)), 0].reshape(-1, 4)


def smoothed(*solids: Solid) -> tuple[np.ndarray, FaceGrid, np.ndarray, np.ndarray]:
    quads = np.concatenate([solid.quads for solid in solids])
    number = np.repeat(np.arange(len(solids)), [len(solid.quads) for solid in solids])
    grid = FaceGrid.over(quads)
    before = by_direction(grid)
    return quads, grid, before, smoothed_over_edges(grid, quads, number, before)


@pytest.mark.parametrize("name", ROUND)
def test_light_at_a_corner_comes_near_the_mean_of_the_faces_that_meet_there_bluntly(name: str) -> None:
    quads, grid, before, after = smoothed(ROUND[name])
    normals = quad_normals(quads)
    flat, own = at_corners(grid, quads, after), at_corners(grid, quads, before)
    off, step = [], []
    for face, quad in enumerate(quads):
        for corner, point in enumerate(quad):
            meeting = [
                own[other, k]
                for other in range(len(quads))
                for k in range(4)
                if np.allclose(quads[other, k], point, atol=1e-6) and normals[other] @ normals[face] > np.cos(0.873)
            ]
            off.append(abs(flat[face, corner] - np.mean(meeting)))
            step.append(abs(own[face, corner] - np.mean(meeting)))
    assert np.max(step) > 0.05
    assert np.mean(off) < 0.3 * np.mean(step)


def test_sharp_edges_and_other_solids_are_left_as_they_are() -> None:
    crate = block(0, 0, 0, (0.4, 0.5, 0.6), GREY)
    _, _, before, after = smoothed(crate)
    np.testing.assert_array_equal(before, after)
    # Sixteen sides of which each is a solid of its own do not know of each other.
    sides = [Solid(quad[None], np.zeros((1, 4, 2)), GREY) for quad in ROUND["cylinder"].quads]
    _, _, before, after = smoothed(*sides)
    np.testing.assert_array_equal(before, after)


def test_the_middle_of_a_large_face_keeps_its_light() -> None:
    quads, grid, before, after = smoothed(soft_box((0, 0, 0), (2.0, 1.6, 0.4), (0.05, 0.05, 0.05), GREY))
    top = int(np.argmax(quads.mean(axis=1)[:, 2]))
    inner = (grid.cell() > 0).all(axis=1) & (grid.cell() < grid.counts[grid.face] - 1).all(axis=1) & (grid.face == top)
    assert inner.sum() > 100
    np.testing.assert_array_equal(before[inner], after[inner])
    assert np.abs(before - after)[grid.face == top].max() > 0.01
