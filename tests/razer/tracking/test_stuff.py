"""Stuff: which pieces are one surface, and what it leaves to things."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from data_tools.synthetic.synthetic_room import SyntheticRoom
from razer.config import MapperConfig
from razer.frame import Frame, Masks
from razer.mapper import Mapper
from razer.models.oracle.embedder import OracleEmbedder
from razer.models.oracle.segmenter import OracleSegmenter
from razer.panoptic_map import PanopticMap
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


STRUCTURE = ("wall", "floor", "ceiling")


class PanopticOracle:
    """Things as they are, and the structure of a room by class, cut into two pieces at a column that changes."""

    def __init__(self) -> None:
        self.things = OracleSegmenter()

    def segment(self, frame: Frame) -> Masks:
        masks = self.things.segment(frame)
        names = masks.class_names or ()
        is_stuff = np.array([name in STRUCTURE for name in names])
        cut = 20 + 37 * frame.index % 120
        pieces, classes = [], []
        for name in STRUCTURE:
            whole = masks.masks[[n == name for n in names]].any(axis=0)
            left = whole.copy()
            left[:, cut:] = False
            for piece in (left, whole & ~left):
                if piece.any():
                    pieces.append(piece)
                    classes.append(name)
        things = masks.select(~is_stuff)
        return Masks(
            np.concatenate([things.masks, np.stack(pieces)]),
            np.concatenate([things.scores, np.full(len(pieces), 0.5, np.float32)]),
            (*(things.class_names or ()), *classes),
            np.repeat([False, True], [len(things), len(pieces)]),
        )


@pytest.fixture(scope="module")
def rooms() -> tuple[PanopticMap, PanopticMap]:
    """A room with things alone, and with its structure as stuff."""
    room, maps = SyntheticRoom(seed=0, n_frames=16, width=160, height=120), []
    for segmenter in (OracleSegmenter(), PanopticOracle()):
        mapper = Mapper(MapperConfig(), segmenter, OracleEmbedder("none"))
        for index in range(16):
            mapper.step(room[index])
        maps.append(mapper.finish())
    return maps[0], maps[1]


def test_a_room_has_one_surface_of_each_class(rooms: tuple[PanopticMap, PanopticMap]) -> None:
    """Walls that meet are one wall, cut as they may be; three by their own masks."""
    plain, panoptic = rooms
    stuff = [o for o in panoptic.objects if o.is_stuff]
    vertices = {name: sorted((o.n_vertices for o in stuff if o.class_name == name), reverse=True) for name in STRUCTURE}
    for name, counts in vertices.items():
        assert counts[0] > 0.98 * sum(counts), name
        # 9 % more of the floor, as none of it is taken for the background of the rest.
        assert counts[0] > 0.98 * sum(o.n_vertices for o in plain.objects if o.class_name == name), name
    assert sum(o.class_name == "wall" for o in plain.objects) > 1


def test_things_of_a_room_keep_their_surface_beside_stuff(rooms: tuple[PanopticMap, PanopticMap]) -> None:
    plain, panoptic = rooms
    things = [[o for o in m.objects if o.class_name not in STRUCTURE] for m in (plain, panoptic)]
    assert sorted(o.class_name or "" for o in things[0]) == sorted(o.class_name or "" for o in things[1])
    n_plain, n_panoptic = (sum(o.n_vertices for o in objects) for objects in things)
    assert n_panoptic == pytest.approx(n_plain, rel=0.03)
