"""Relations that a person would accept, where boxes mislead: leaks, doubles, hidden feet, rims and compartments."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from razer.boxes.oriented_box import OrientedBox
from razer.semantics.relations import relations
from razer.semantics.upright_instance import UprightInstance
from tests.razer.semantics.test_relations import ALL, FLOOR, TOP, WALL, face, merged, shelf, solid, table

SIDES = ((0, 1), (0, -1), (1, 1), (1, -1))


def edges(*instances, background=None):
    return {(e.source, e.relation, e.target) for e in relations(instances, background)}


def with_points(instance, points, normals):
    return replace(
        instance, points=np.concatenate([instance.points, points]), normals=np.concatenate([instance.normals, normals])
    )


def named(instance, name):
    return replace(instance, name=name)


def crate(number, z=0.0, height=0.3):
    """An open box of 0.6 x 0.5 m whose walls are seen from inside and outside."""
    walls = [((s * 0.3, 0, z + height / 2), (0.02, 0.5, height), ALL) for s in (-1, 1)]
    walls += [((0, s * 0.25, z + height / 2), (0.6, 0.02, height), ALL) for s in (-1, 1)]
    return merged(number, [((0, 0, z + 0.01), (0.6, 0.5, 0.02), TOP), *walls])


def test_a_cup_on_a_table_whose_box_reaches_the_floor_is_on_it_even_if_the_label_of_the_table_climbs_it():
    cup = solid(4, (0.3, 0.1, 0.80), (0.09, 0.09, 0.1))
    low = cup.points[:, 2] < 0.78
    leaked = with_points(table(3), cup.points[low], cup.normals[low])
    left = replace(cup, points=cup.points[~low], normals=cup.normals[~low])
    assert (4, "on", 3) in edges(FLOOR, leaked, left)
    assert not {e for e in edges(FLOOR, leaked, left) if e[1] == "in"}


def test_a_cup_below_the_rim_of_a_crate_is_in_it_and_one_on_a_tray_is_on_it():
    cup = solid(4, (0.05, 0, 0.08), (0.09, 0.09, 0.12))
    assert (4, "in", 3) in edges(FLOOR, crate(3), cup)
    assert (4, "on", 3) in edges(crate(3, height=0.03), cup)


def test_a_compartment_needs_a_back_and_two_sides():
    books = solid(4, (0, -0.05, 0.64), (0.5, 0.15, 0.24), ((0, 1), (0, -1), (1, 1), (2, 1)))
    boards = [((0, 0, z), (1.0, 0.3, 0.03), ALL) for z in (0.02, 0.5, 1.0, 1.5)]
    posts = [((i * 0.5, j * 0.15, 0.75), (0.03, 0.03, 1.5), ALL) for i in (-1, 1) for j in (-1, 1)]
    assert (4, "in", 3) in edges(shelf(3), books)
    assert (4, "on", 3) in edges(merged(3, boards + posts), books)


def test_a_strip_of_floor_with_a_chairs_label_makes_nothing_stand_on_the_chair():
    fridge = solid(4, (0, 0, 0.9), (0.6, 0.6, 1.8))
    chair = merged(3, [((0.8, 0, 0.45), (0.4, 0.4, 0.03), ALL), ((1.0, 0, 0.65), (0.03, 0.4, 0.4), ALL)])
    strip, up = face((0.45, 0, 0), (0.3, 0.6, 0.0), 2, 1)
    rest = UprightInstance(0, FLOOR.points, FLOOR.normals, OrientedBox.around(FLOOR.points, np.eye(3)))
    leaked = with_points(chair, strip, up)
    assert not {e for e in edges(leaked, fridge, background=rest) if e[1] in ("on", "in", "under")}


def halves(number, other):
    """A screen of 1 x 0.6 m in two pieces, one above the other, seen from the front."""
    return [named(solid(n, (0, 0, z), (1.0, 0.05, 0.3), ((1, 1),)), "tv") for n, z in ((number, 0.95), (other, 0.65))]


def test_pieces_of_one_thing_have_no_relation_to_each_other():
    upper, lower = halves(4, 5)
    stand = named(solid(3, (0, 0, 0.25), (1.4, 0.4, 0.5)), "tv stand")
    found = edges(FLOOR, stand, upper, lower)
    assert not {e for e in found if {e[0], e[2]} == {4, 5}}
    assert (5, "on", 3) in found


def test_a_thing_mapped_twice_has_no_relation_to_its_double():
    chair = named(solid(4, (0, 0, 0.4), (0.4, 0.4, 0.8)), "chair")
    double = replace(chair, id=5, points=chair.points[::2] + 0.01, normals=chair.normals[::2])
    assert edges(FLOOR, chair, double) == {(4, "on", 1), (5, "on", 1)}


def test_boxes_of_one_class_may_stand_on_each_other():
    below = named(solid(3, (0, 0, 0.2), (0.6, 0.6, 0.4)), "box")
    above = named(solid(4, (0.02, 0, 0.55), (0.3, 0.3, 0.3)), "box")
    assert edges(FLOOR, below, above) == {(3, "on", 1), (4, "on", 3)}


@pytest.mark.parametrize(("gap_m", "seen_beneath", "stands"), [(0.2, False, True), (0.2, True, False)])
def test_a_thing_whose_foot_is_hidden_stands_unless_its_support_is_seen_beneath_it(gap_m, seen_beneath, stands):
    cabinet = solid(4, (0, 0, gap_m + 0.3), (0.6, 0.6, 0.6))
    beneath = (np.abs(FLOOR.points[:, :2]) < 0.32).all(axis=1) & (not seen_beneath)
    floor = replace(FLOOR, points=FLOOR.points[~beneath], normals=FLOOR.normals[~beneath])
    assert ((4, "on", 1) in edges(floor, cabinet)) == stands


def test_only_the_direct_support_carries_and_what_stands_on_furniture_is_not_against_the_wall():
    sideboard = solid(3, (0, -1.75, 0.4), (1.2, 0.4, 0.8))
    box = solid(4, (0, -1.85, 0.9), (0.2, 0.2, 0.2))
    assert edges(FLOOR, WALL, sideboard, box) == {(3, "on", 1), (3, "against", 2), (4, "on", 3)}


def test_a_board_between_keeps_one_book_from_being_under_another():
    rack = merged(3, [((0, 0, z), (1.0, 0.3, 0.03), ALL) for z in (0.1, 0.5, 0.9, 1.3)])
    low, high = (solid(n, (0, 0, z), (0.2, 0.2, 0.06)) for n, z in ((4, 0.55), (5, 0.95)))
    assert edges(rack, low, high) == {(4, "on", 3), (5, "on", 3)}
