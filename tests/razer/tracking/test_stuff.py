"""Stuff: which pieces are one surface, and what it leaves to things."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from razer.tracking.stuff import meeting_pairs, surface_beneath
from tests.support.cell_world import CellMask, CellWorld, rectangle

FLOOR = CellMask(rectangle(0, 20, 0, 20), (1, 0, 0), stuff="floor")
RUG = replace(FLOOR, stuff="rug")
CHAIR = CellMask(rectangle(4, 10, 4, 10), (0, 1, 0))
CHAIR_ALIKE = replace(CHAIR, embedding=FLOOR.embedding)


def grid(x: range, y: range, z: range) -> np.ndarray:
    return np.array([(i, j, k) for i in x for j in y for k in z], np.int32)


NORTH = grid(range(30), range(1), range(20))
CASES = {
    "a corner": (grid(range(29, 30), range(1, 30), range(20)), True),
    "a corner with a voxel left out": (grid(range(31, 32), range(30), range(20)), True),
    "a gap of ten voxels": (grid(range(40, 60), range(1), range(20)), False),
    "behind each other": (grid(range(30), range(6, 7), range(20)), False),
    "a corner of seven voxels": (grid(range(30, 31), range(1), range(7)), False),
    "a corner of eight voxels": (grid(range(30, 31), range(1), range(8)), True),
}


@pytest.mark.parametrize(("other", "meet"), CASES.values(), ids=CASES.keys())
def test_walls_are_one_where_they_meet(other: np.ndarray, meet: bool) -> None:
    coordinates = np.concatenate([NORTH, other])
    labels = np.repeat([3, 5], [len(NORTH), len(other)])
    assert meeting_pairs(coordinates, labels, {3: "wall", 5: "wall"}) == ([(3, 5)] if meet else [])
    assert meeting_pairs(coordinates[::-1], labels[::-1], {5: "wall", 3: "wall"}) == ([(3, 5)] if meet else [])
    assert meeting_pairs(coordinates, labels, {3: "wall", 5: "floor"}) == []


def test_a_piece_belongs_to_the_surface_beneath_most_of_it() -> None:
    assert surface_beneath({}) is None
    assert surface_beneath({4: 7}) is None
    assert surface_beneath({4: 8, 2: 8, 9: 5}) == 2
    assert surface_beneath({4: 9, 2: 8}) == 4


def outcomes(world: CellWorld, *masks: CellMask) -> list[tuple[str, int]]:
    return [(d.outcome, d.track_id) for d in world.frame(*masks)]


def test_things_and_stuff_never_match_whatever_they_look_like() -> None:
    world = CellWorld()
    assert outcomes(world, FLOOR) == [("born", 1)]
    assert outcomes(world, replace(FLOOR, stuff=None)) == [("born", 2)]
    assert outcomes(world, RUG) == [("born", 3)]
    assert outcomes(world, FLOOR) == [("matched", 1)]


def test_pieces_of_a_floor_in_one_frame_are_all_of_it() -> None:
    """What stands on it cuts it into pieces; a detector's thing in two pieces would be two."""
    world = CellWorld()
    world.frame(FLOOR)
    left, right = (replace(FLOOR, cells=rectangle(0, 20, *columns)) for columns in ((0, 4), (10, 20)))
    assert sorted(outcomes(world, left, right)) == [("joined", 1), ("matched", 1)]


def test_stuff_takes_no_voxel_of_a_thing() -> None:
    world = CellWorld()
    for _ in range(2):
        world.frame(CHAIR_ALIKE, replace(FLOOR, cells=FLOOR.cells - CHAIR.cells))
    (decision,) = world.frame(FLOOR)
    assert (decision.track_id, decision.spares) == (2, (1,))


def test_stuff_takes_voxels_of_what_is_likely_no_thing() -> None:
    world = CellWorld()
    world.frame(replace(CHAIR, score=0.3))
    assert world.frame(FLOOR)[0].spares == ()


def test_surfaces_that_meet_become_the_oldest_of_them() -> None:
    world = CellWorld()
    for columns in ((0, 5), (10, 15), (20, 25), (30, 35)):
        world.frame(replace(FLOOR, cells=rectangle(0, 20, *columns)))
    assert world.tracker.fuse_stuff([(2, 3), (3, 4)]) == [(3, 2), (4, 2)]
    assert world.tracker.fuse_stuff([(1, 4), (1, 2)]) == [(2, 1)]
    assert sorted(world.tracker.tracks) == [1]
