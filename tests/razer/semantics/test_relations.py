"""Relations of hand-made things in a room whose z points up, and the direction up itself."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.testing import assert_allclose
from scipy.spatial.transform import Rotation

from razer.boxes.oriented_box import OrientedBox
from razer.mesh.labelled_mesh import LabelledMesh
from razer.semantics.gravity import up_direction
from razer.semantics.relations import Relation, _is_parted, relations
from razer.semantics.upright_instance import UprightInstance

STEP_M = 0.03


def face(center, size, axis, sign):
    """Points and normals of one face of a box."""
    others = [a for a in range(3) if a != axis]
    grid = [np.arange(-size[a] / 2, size[a] / 2 + 1e-9, STEP_M) for a in others]
    one, two = np.meshgrid(*grid)
    points = np.zeros((one.size, 3))
    points[:, others[0]], points[:, others[1]] = one.ravel(), two.ravel()
    points[:, axis] = sign * size[axis] / 2
    normals = np.zeros_like(points)
    normals[:, axis] = sign
    return points + np.asarray(center, float), normals


def solid(number, center, size, sides=((0, 1), (0, -1), (1, 1), (1, -1), (2, 1)), stuff=False):
    """A box seen from all sides but from below, unless stated otherwise."""
    return merged(number, [(center, size, sides)], stuff)


ALL = ((0, 1), (0, -1), (1, 1), (1, -1), (2, 1), (2, -1))
TOP = ((2, 1),)


def merged(number, boxes, stuff=False):
    parts = [face(center, size, *side) for center, size, sides in boxes for side in sides]
    points, normals = (np.concatenate(columns) for columns in zip(*parts, strict=True))
    return UprightInstance(number, points, normals, OrientedBox.around(points, np.eye(3)), stuff)


def table(number, x=0.0, y=0.0):
    """A top of 1.2 x 0.8 m at 0.75 m on four legs."""
    legs = [((x + i * 0.55, y + j * 0.35, 0.35), (0.05, 0.05, 0.7), ALL) for i in (-1, 1) for j in (-1, 1)]
    return merged(number, [((x, y, 0.73), (1.2, 0.8, 0.04), ALL), *legs])


def shelf(number, x=0.0, y=0.0):
    """Two sides, a back and four boards, open to +y; 1 m wide, 0.3 m deep, 1.5 m high."""
    boards = [((x, y, z), (1.0, 0.3, 0.03), ALL) for z in (0.02, 0.5, 1.0, 1.5)]
    sides = [((x + i * 0.5, y, 0.75), (0.03, 0.3, 1.5), ALL) for i in (-1, 1)]
    return merged(number, [*boards, *sides, ((x, y - 0.15, 0.75), (1.0, 0.02, 1.5), ALL)])


FLOOR = solid(1, (0, 0, -0.01), (6, 6, 0.02), TOP, stuff=True)
WALL = solid(2, (0, -2, 1.25), (6, 0.02, 2.5), ((1, 1),), stuff=True)


def triples(*instances):
    return {(e.source, e.relation, e.target) for e in relations(instances)}


def test_what_stands_on_the_floor():
    assert triples(FLOOR, solid(3, (0, 0, 0.3), (0.5, 0.5, 0.6))) == {(3, "on", 1)}


def test_a_floor_that_is_hidden_beneath_a_thing_still_carries_it():
    box = solid(3, (0, 0, 0.3), (1.0, 1.0, 0.6))
    seen = ~((np.abs(FLOOR.points[:, 0]) < 0.45) & (np.abs(FLOOR.points[:, 1]) < 0.45))
    floor = UprightInstance(1, FLOOR.points[seen], FLOOR.normals[seen], FLOOR.box, True)
    assert triples(floor, box) == {(3, "on", 1)}


def test_a_cup_on_a_table_on_a_floor():
    cup = solid(4, (0.3, 0.1, 0.80), (0.09, 0.09, 0.1))
    assert triples(FLOOR, table(3), cup) == {(3, "on", 1), (4, "on", 3)}


def test_a_stool_under_a_table_is_neither_on_nor_in_it():
    stool = solid(4, (0, 0, 0.2), (0.4, 0.4, 0.4))
    assert triples(FLOOR, table(3), stool) == {(3, "on", 1), (4, "on", 1), (4, "under", 3)}


def test_books_in_a_shelf_and_a_box_on_top_of_it():
    books = solid(4, (0, -0.05, 0.64), (0.5, 0.15, 0.24), ((0, 1), (0, -1), (1, 1), (2, 1)))
    box = solid(5, (0.2, 0, 1.62), (0.2, 0.2, 0.2))
    assert triples(shelf(3), books, box) == {(4, "in", 3), (5, "on", 3)}


def test_a_picture_and_a_cabinet_against_a_wall():
    picture = solid(3, (0, -1.97, 1.5), (0.6, 0.02, 0.4), ((1, 1),))
    cabinet = solid(4, (2, -1.75, 0.4), (0.8, 0.4, 0.8))
    assert triples(FLOOR, WALL, picture, cabinet) == {(3, "against", 2), (4, "against", 2), (4, "on", 1)}


@pytest.mark.parametrize(("gap_m", "expected"), [(0.2, {(3, "next to", 4)}), (0.5, set())])
def test_chairs_side_by_side_are_next_to_each_other_once(gap_m, expected):
    chairs = [solid(3, (0, 0, 0.4), (0.4, 0.4, 0.8)), solid(4, (0.4 + gap_m, 0, 0.4), (0.4, 0.4, 0.8))]
    assert triples(*chairs) == expected
    assert triples(*reversed(chairs)) == expected


def test_things_above_each_other_are_not_next_to_each_other():
    assert triples(solid(3, (0, 0, 0.2), (0.3, 0.3, 0.4)), solid(4, (0.35, 0, 0.75), (0.3, 0.3, 0.4))) == set()


def test_what_only_a_point_left_out_of_a_sample_is_near_to_breaks_nothing():
    # One of 3000 points is beside the shelf, and is not among every second one.
    points = np.tile([9.0, 0.0, 0.5], (3000, 1))
    points[1] = 0.7, 0.0, 0.5
    sparse = UprightInstance(4, points, np.tile([1.0, 0.0, 0.0], (3000, 1)), OrientedBox.around(points, np.eye(3)))
    assert not _is_parted(sparse, shelf(3), WALL)


def test_distances_are_those_of_surfaces():
    edge = relations([solid(3, (0, 0, 0.4), (0.39, 0.39, 0.8)), solid(4, (0.6, 0, 0.4), (0.39, 0.39, 0.8))])[0]
    assert edge == Relation(3, 4, "next to", pytest.approx(0.21, abs=0.02))


def test_stuff_has_no_relations_of_its_own():
    ceiling = solid(5, (0, 0, 2.5), (6, 6, 0.02), ((2, -1),), stuff=True)
    assert triples(FLOOR, WALL, ceiling) == set()


def test_a_speck_and_a_line_do_not_break_anything():
    speck = UprightInstance(
        8, np.array([[0, 0, 0.01]]), np.array([[0, 0, 1.0]]), OrientedBox(np.zeros(3), np.eye(3), np.zeros(3))
    )
    points = np.stack([np.linspace(0, 1, 30), np.zeros(30), np.full(30, 0.5)], axis=1)
    line = UprightInstance(9, points, np.tile([0, 0, 1.0], (30, 1)), OrientedBox.around(points, np.eye(3)))
    assert (8, "on", 1) in triples(FLOOR, speck, line)


def floor_mesh(turn, noise=0.0):
    """A floor, a lower part of a wall, and a tilted board, in a world turned by `turn` (3, 3)."""
    rng = np.random.default_rng(0)
    parts, triangles = [], []
    for corners in (
        [(0, 0, 0), (4, 0, 0), (4, 4, 0), (0, 4, 0)],
        [(0, 0, 0), (0, 0, 1), (4, 0, 1), (4, 0, 0)],
        [(1, 1, 0), (2, 1, 0.8), (2, 2, 0.8), (1, 2, 0)],
    ):
        first = 4 * len(parts)
        parts.append(np.array(corners, float))
        triangles += [(first, first + 1, first + 2), (first, first + 2, first + 3)]
    vertices = ((np.concatenate(parts) + noise * rng.standard_normal((12, 3))) @ turn.T).astype(np.float32)
    return LabelledMesh(vertices, np.zeros((12, 3), np.uint8), np.zeros(12, np.int32), np.array(triangles, np.int32))


@pytest.mark.parametrize("tilt_deg", [0, 20, 35])
def test_up_is_found_from_a_tilted_guess(tilt_deg):
    turn = Rotation.from_euler("xyz", [130, 20, 70], degrees=True).as_matrix()
    guess = turn @ Rotation.from_euler("y", tilt_deg, degrees=True).as_matrix() @ [0, 0, 2.0]
    assert_allclose(up_direction(floor_mesh(turn), guess), turn @ [0, 0, 1], atol=1e-5)


def test_without_level_surface_the_guess_is_kept():
    empty = LabelledMesh(
        *(np.zeros((0, 3), kind) for kind in (np.float32, np.uint8)), np.zeros(0, np.int32), np.zeros((0, 3), np.int32)
    )
    assert_allclose(up_direction(empty, np.array([0, -3.0, 0])), [0, -1, 0])
