"""Supports and walls that nobody saw: hidden feet and backs, boards without a label, and what hangs flat on a wall."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from razer.semantics.hidden_foot import is_hidden_below
from razer.semantics.relations import relations
from razer.semantics.upright_instance import UprightInstance
from razer.semantics.wall_contact import is_against, lies_flat, wall_plane
from tests.razer.semantics.test_relations import FLOOR, TOP, WALL, merged, solid

WALL_Y = -1.99
FROM_FRONT = ((1, 1), (0, 1), (0, -1), (2, 1))


def edges(*instances, background=None):
    return {(e.source, e.relation, e.target) for e in relations(instances, background)}


def where(instance, rows):
    return replace(instance, points=instance.points[rows], normals=instance.normals[rows])


def flat(number, low, high, wide=1.0):
    """A pane that stands out 6 cm from the wall."""
    return solid(number, (0, WALL_Y + 0.03, (low + high) / 2), (wide, 0.06, high - low), FROM_FRONT)


def hidden(floor_x=0.8):
    """A nightstand at the wall that hides the floor and the wall near it, and of which the lowest 20 cm are hidden."""
    nightstand = solid(3, (0, -1.75, 0.35), (0.4, 0.4, 0.3))
    floor = where(FLOOR, np.abs(FLOOR.points[:, 0]) > floor_x)
    return nightstand, where(floor, floor.points[:, 0] > 0)


def test_what_hides_its_foot_stands_on_the_floor_of_the_room_though_none_of_it_is_seen_near_by():
    nightstand, floor = hidden()
    wall = where(WALL, (np.abs(WALL.points[:, 0]) > 0.2) | (WALL.points[:, 2] > 0.5))
    assert (3, "on", 1) in edges(floor, wall, nightstand)
    assert (3, "on", 1) in edges(floor, nightstand)
    assert not edges(hidden(floor_x=2.9)[1], nightstand), "no floor is known there"


@pytest.mark.parametrize("below", ["wall", "table"])
def test_what_has_a_wall_or_a_table_seen_below_it_does_not_stand_on_the_floor(below):
    nightstand, floor = hidden()
    seen = WALL if below == "wall" else solid(4, (0, -1.75, 0.1), (0.4, 0.4, 0.02), TOP)
    assert (3, "on", 1) not in edges(floor, seen, nightstand)


def test_a_column_is_hidden_unless_three_tenths_of_it_are_seen():
    foot = where(solid(3, (0, 0, 0.5), (0.4, 0.4, 0.02), ((2, -1),)), slice(None)).points
    beneath = FLOOR.points[(np.abs(FLOOR.points[:, :2]) <= 0.2).all(axis=1)] + [0, 0, 0.1]
    for share, expected in ((0.2, True), (0.5, False)):
        rows = beneath[:, 0] <= np.quantile(beneath[:, 0], share)
        other = replace(FLOOR, points=beneath[rows], normals=np.tile([0.0, 0.0, 1.0], (rows.sum(), 1)))
        assert is_hidden_below(foot, 0.0, [other], []) == expected


@pytest.mark.parametrize(("counter_top", "relation"), [(0.95, "against"), (1.0, "on")])
def test_a_window_hangs_on_its_wall_unless_its_edge_rests_on_what_stands_before_it(counter_top, relation):
    counter = solid(4, (0, -1.69, counter_top / 2), (1.6, 0.6, counter_top))
    found = edges(FLOOR, WALL, counter, flat(3, 1.0, 2.0))
    assert {(r, b) for a, r, b in found if a == 3} == {(relation, 2 if relation == "against" else 4)}


def test_a_window_above_a_suitcase_of_its_height_that_stands_before_it_hangs():
    suitcase = solid(4, (0.4, -1.7, 0.5), (0.4, 0.25, 1.0))
    assert {(r, b) for a, r, b in edges(FLOOR, WALL, suitcase, flat(3, 1.0, 2.0)) if a == 3} == {("against", 2)}


def test_a_sheet_on_a_wall_is_flat_and_a_cupboard_is_not():
    for thing, expected in ((flat(3, 1.0, 2.0), True), (solid(3, (0, -1.8, 1.0), (0.8, 0.4, 1.0)), False)):
        assert lies_flat(thing, wall_plane(thing, WALL)) == expected


@pytest.mark.parametrize(("gap_m", "is_seen", "expected"), [(0.05, 2, True), (0.05, 1, False), (0.2, 2, False)])
def test_a_wall_goes_on_behind_what_hides_it_where_it_is_seen_on_both_sides(gap_m, is_seen, expected):
    cabinet = solid(3, (0, WALL_Y + gap_m + 0.2, 0.5), (0.8, 0.4, 1.0))
    beside = np.abs(WALL.points[:, 0]) > 0.55 if is_seen == 2 else WALL.points[:, 0] > 0.55
    assert is_against(cabinet, where(WALL, beside & (WALL.points[:, 2] < 1.0))) == expected


def board(number, x_low, x_high):
    """Part of a board at 1 m, 0.3 m deep, along the wall."""
    return solid(number, ((x_low + x_high) / 2, -1.84, 0.99), (x_high - x_low, 0.3, 0.02), TOP)


def rack(*parts):
    posts = [((s * 0.6, -1.84, 0.75), (0.03, 0.3, 1.5), ((0, 1), (0, -1))) for s in (-1, 1)]
    own = merged(4, posts)
    points, normals = [own.points, *(p.points for p in parts)], [own.normals, *(p.normals for p in parts)]
    return replace(own, points=np.concatenate(points), normals=np.concatenate(normals))


@pytest.mark.parametrize("labelled", [True, False])
def test_a_box_on_a_board_without_a_label_is_on_the_rack_whose_board_goes_on_there_and_never_against_the_wall(labelled):
    box = solid(3, (0, -1.84, 1.06), (0.2, 0.2, 0.12))
    ends = (board(9, -0.6, -0.25), board(9, 0.25, 0.6)) if labelled else ()
    middle = board(9, -0.25, 0.25)
    rest = UprightInstance(0, middle.points, middle.normals, middle.box)
    found = {e for e in edges(FLOOR, WALL, rack(*ends), box, background=rest) if e[0] == 3}
    assert found == ({(3, "on", 4)} if labelled else set())


def test_what_stands_on_the_lowest_board_of_a_rack_does_not_carry_it():
    paper = solid(5, (0, -1.84, 0.12), (0.5, 0.25, 0.02), ((2, 1), (1, 1)))
    low = merged(4, [((0, -1.84, 0.09), (1.2, 0.3, 0.02), TOP), ((0, -1.84, 1.0), (1.2, 0.3, 0.02), TOP)])
    feet = solid(9, (0, -1.84, 0.03), (1.2, 0.3, 0.06), ((1, 1),))
    shelf = replace(low, points=np.r_[low.points, feet.points[::40]], normals=np.r_[low.normals, feet.normals[::40]])
    found = edges(FLOOR, WALL, shelf, paper)
    assert (5, "on", 4) in found
    assert (4, "on", 1) in found


def test_a_neck_above_the_body_of_a_guitar_whose_middle_is_missing_does_not_stand_on_it():
    body, neck = (solid(n, (0, 0, z), (0.12, 0.12, 0.5)) for n, z in ((3, 0.25), (4, 0.79)))
    assert not {e for e in edges(FLOOR, *(replace(p, name="guitar") for p in (body, neck))) if e[:2] == (4, "on")}
