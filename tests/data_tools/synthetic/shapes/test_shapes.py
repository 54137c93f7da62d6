"""The building blocks of furniture: their volumes, places and textures."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest

from data_tools.synthetic.rendering.procedural_textures import PAINTERS
from data_tools.synthetic.rendering.ray_renderer import RayRenderer
from data_tools.synthetic.shapes import primitives as shapes
from data_tools.synthetic.shapes.solids import Material, Solid
from data_tools.synthetic.shapes.thing import Thing, tinted
from data_tools.synthetic.shapes.transforms import fitted, stretched, turned
from razer.frame import Intrinsics
from tests.support.solids import signed_volume

GREY = tinted("smooth", (200.0, 200.0, 200.0))
SQUARE = [(-1, -1), (1, -1), (1, 1), (-1, 1)]


def octagon(width: float, depth: float, cut: float) -> float:
    return width * depth - 2 * cut * cut


@pytest.mark.parametrize(
    ("solid", "expected"),
    [
        (shapes.block(3, 1, 2, (2, 3, 4), GREY), 24),
        (shapes.prism(SQUARE, 1, 4, GREY), 12),
        (shapes.prism(SQUARE[:3], 1, 4, GREY), 6),
        (shapes.cylinder(0.5, 0, 2, GREY, 12), 2 * 6 * 0.25 * np.sin(np.pi / 6)),
        (shapes.cylinder(0.5, 0, 2, GREY, 7), 2 * 3.5 * 0.25 * np.sin(2 * np.pi / 7)),
        # A frustum: h / 3 (A + B + sqrt(A B)).
        (shapes.tapered((-2, -2, 2, 2), (-1, -1, 1, 1), 0, 3, GREY), 16 + 4 + 8),
        (shapes.layered([(2, 2, 0), (1, 1, 3), (2, 2, 6)], GREY), 2 * (16 + 4 + 8)),
        (shapes.rounded((0, 0, 0), (2, 3, 4), "x", 0.5, GREY), 2 * octagon(3, 4, 0.5)),
        (shapes.rounded((0, 0, 0), (2, 3, 4), "y", 0.5, GREY), 3 * octagon(2, 4, 0.5)),
        (shapes.rounded((0, 0, 0), (2, 3, 4), "z", 0.5, GREY), 4 * octagon(2, 3, 0.5)),
        (shapes.tetrahedron([(0, 0, 0), (1, 0, 0), (0, 1, 0), (0, 0, 1)], GREY), 1 / 6),
        (shapes.beam((1, 2, 3), (2, 4, 5), 0.2, 0.1, GREY), 3 * 0.02),
        (stretched(shapes.block(0, 0, 0, (1, 1, 1), GREY), (2, 3, 4)), 24),
    ],
)
def test_solids_enclose_the_volume_that_geometry_says(solid: Solid, expected: float) -> None:
    assert signed_volume(solid) == pytest.approx(expected)


def test_a_soft_box_is_the_box_less_its_edges_and_corners() -> None:
    bevel = 0.25
    solid = shapes.soft_box((0, 0, 0), (2, 3, 4), (bevel, bevel, bevel), GREY)
    assert len(solid.quads) == 26
    # Twelve prisms along the inner edges and eight corners, each a cube of the bevel less the tetrahedron left in it.
    edges = 4 * ((2 - 2 * bevel) + (3 - 2 * bevel) + (4 - 2 * bevel)) * bevel**2 / 2
    corners = 8 * bevel**3 * (1 - 1 / 6)
    assert signed_volume(solid) == pytest.approx(24 - edges - corners)
    assert solid.quads.min(axis=(0, 1)) == pytest.approx((0, 0, 0))
    assert solid.quads.max(axis=(0, 1)) == pytest.approx((2, 3, 4))


def test_a_bowed_panel_is_bent_backwards_and_leans_between_its_edges() -> None:
    width, bow, thick = 0.4, 0.06, 0.02
    panel = shapes.bowed(width, bow, thick, (0.5, 0.9), (0.1, -0.1), GREY)
    # A parabola's area is sampled at the joints of its parts; shifting each height by its lean changes no volume.
    assert signed_volume(panel) == pytest.approx(width * thick * 0.4)
    low, high = panel.quads.min(axis=(0, 1)), panel.quads.max(axis=(0, 1))
    assert low == pytest.approx((-0.2, -0.1 - bow - thick, 0.5))
    assert high == pytest.approx((0.2, 0.1, 0.9))
    points = panel.quads.reshape(-1, 3)
    middle_above = points[(np.abs(points[:, 0]) < 1e-9) & (points[:, 2] > 0.89)]
    assert middle_above[:, 1].max() == pytest.approx(-0.1 - bow)


def test_a_ball_fills_its_ellipsoid_with_many_faces_and_touches_it() -> None:
    solid = shapes.ball((1, 2, 3), (0.5, 1, 2), GREY, sides=64, rings=32)
    assert signed_volume(solid) == pytest.approx(4 / 3 * np.pi, rel=0.01)
    unit = (solid.quads - (1, 2, 3)) / (0.5, 1, 2)
    assert np.linalg.norm(unit, axis=2) == pytest.approx(1)


@pytest.mark.parametrize("make", [shapes.tube, lambda a, b, r, m: shapes.beam(a, b, 2 * r, 2 * r, m)])
@pytest.mark.parametrize("end", [(1, 2, 5), (1, 2, -1), (4, 2, 3), (1, -3, 3), (2, 3, 4)])
def test_rods_and_beams_run_from_point_to_point(make: Callable[..., Solid], end: tuple[float, float, float]) -> None:
    start = np.array((1.0, 2.0, 3.0))
    solid = make(tuple(start), end, 0.1, GREY)
    axis = (end - start) / np.linalg.norm(end - start)
    along = (solid.quads.reshape(-1, 3) - start) @ axis
    aside = np.linalg.norm(solid.quads.reshape(-1, 3) - start - along[:, None] * axis, axis=1)
    assert along.min() == pytest.approx(0, abs=1e-9)
    assert along.max() == pytest.approx(np.linalg.norm(end - start))
    assert aside.max() <= 0.1 * np.sqrt(2) + 1e-9
    assert signed_volume(solid) > 0


def test_a_beams_width_lies_horizontally() -> None:
    low, high = Thing("x", (shapes.beam((0, 0, 1), (0, 3, 1), 0.6, 0.1, GREY),)).bounds
    assert high - low == pytest.approx((0.6, 3, 0.1))


def test_bars_join_the_points_in_turn() -> None:
    points = [(0.0, 0.0, 0.0), (1.0, 0.0, 0.0), (1.0, 1.0, 0.0)]
    assert len(shapes.bars(points, 0.1, 0.1, GREY)) == 2
    ring = shapes.bars(points, 0.1, 0.1, GREY, closed=True)
    assert sum(map(signed_volume, ring)) == pytest.approx((2 + np.sqrt(2)) * 0.01)


def test_turning_x_by_minus_ninety_brings_up_to_front() -> None:
    raised = turned(shapes.block(0, 0, 1, (0.2, 0.2, 1), GREY), "x", -90, (5, 0, 0))
    assert Thing("x", (raised,)).bounds == (pytest.approx((4.9, 1, -0.1)), pytest.approx((5.1, 2, 0.1)))
    plate = Thing("x", (shapes.disc(0.5, 0.1, (1, 2, 3), GREY),))
    assert plate.bounds == (pytest.approx((0.5, 2, 2.5)), pytest.approx((1.5, 2.1, 3.5)))


def test_a_fitted_landscape_stands_upright_for_who_faces_it() -> None:
    sheet = fitted(shapes.block(0, 0, 0, (1, 0.1, 1), Material("landscape", (0, 0, 0), (255, 255, 255))))
    # A camera at y = 3 that looks along -y: its x axis is the world's -x, its y axis points down.
    world_from_camera = np.eye(4)
    world_from_camera[:3, :3] = np.array([(-1, 0, 0), (0, 0, -1), (0, -1, 0)]).T
    world_from_camera[:3, 3] = 0, 3, 0.5
    camera = Intrinsics(64, 64, 180.0, 180.0, 31.5, 31.5)
    rgb, _, ids, _ = RayRenderer({1: Thing("picture", (sheet,))}, camera).render(world_from_camera)
    rows, columns = np.nonzero(ids == 1)
    grey = rgb[rows.min() : rows.max() + 1, columns.min() : columns.max() + 1, 0].astype(float)
    texture = PAINTERS["landscape"](np.random.default_rng([0, list(PAINTERS).index("landscape")])).clip(0, 1)
    cells = texture[: 512 // len(grey) * len(grey), : 512 // len(grey[0]) * len(grey[0])]
    small = cells.reshape(len(grey), -1, len(grey[0]), cells.shape[1] // len(grey[0])).mean(axis=(1, 3))
    assert np.corrcoef(small.ravel(), grey.ravel())[0, 1] > 0.9
    assert (
        np.corrcoef(small[:, ::-1].ravel(), grey.ravel())[0, 1] < np.corrcoef(small.ravel(), grey.ravel())[0, 1] - 0.02
    )
