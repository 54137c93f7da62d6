"""A hall with rows of racks full of boxes, and a walk along the lanes between them."""

from __future__ import annotations

import numpy as np

from data_tools.synthetic.camera.camera_path import CameraPath
from data_tools.synthetic.layout.building import SIDES, Room, shell
from data_tools.synthetic.layout.finishes import concrete_floor, finish
from data_tools.synthetic.layout.free_space import EmptyCells, FreeSpace
from data_tools.synthetic.layout.furnishing import against, load, piece, scatter, window, workplace
from data_tools.synthetic.layout.placement import Placer
from data_tools.synthetic.scenes.world import World
from data_tools.synthetic.shapes import materials as m
from data_tools.synthetic.shapes.primitives import block, legs
from data_tools.synthetic.shapes.thing import Thing, tinted

_SIZE_M = (15.0, 10.0)
_HEIGHT_M = 4.2
_ROWS_M = (3.4, 6.6)
_RACKS = 3
_RACK_M = (2.3, 0.75)
_BOARDS_M = (0.14, 0.95, 1.76)
_SWAY_DEG = 50.0
_STORED = (*("box",) * 8, "storage bin", "storage bin", "crate", "basket", "bucket", "paper bag")


def warehouse(seed: int) -> World:
    """Two rows of equal racks with some 100 boxes, bins and crates, stacks along the walls, ladders and carts, and a
    workplace; the seed varies what stands where, and colours."""
    rng = np.random.default_rng([seed, 51])
    placer = Placer(rng)
    room = Room((0, 0), _SIZE_M, _HEIGHT_M)
    for thing in shell(room, (), finish(concrete_floor(rng), rng)):
        placer.add(thing)
    first_x = float(rng.uniform(4.4, 5.2))
    _racks(room, placer, first_x)
    _walls(room, placer)
    _floor(room, placer, first_x)
    path = _camera_path(placer.things, first_x)
    return World(dict(enumerate(placer.things, start=1)), tuple(path.stations), placer.relations)


def _racks(room: Room, placer: Placer, first_x: float) -> None:
    rack = _rack(placer.rng)
    for y in _ROWS_M:
        for number in range(_RACKS):
            put = placer.on_floor(room, rack, first_x + number * (_RACK_M[0] + 0.12), y)
            for level in range(len(_BOARDS_M)):
                load(placer, put, *placer.rng.permutation(_STORED)[: int(placer.rng.integers(6, 10))], level=level)


def _rack(rng: np.random.Generator) -> Thing:
    """Boards between steel beams on four posts."""
    (width, deep), top = _RACK_M, _BOARDS_M[-1]
    steel = tinted("smooth", m.around(rng, ((40, 80, 160), (200, 90, 40), (60, 120, 80))), 0.2)
    board = tinted("wood", m.around(rng, ((205, 170, 120), (185, 150, 105))), 0.4, 1.2)
    solids = legs(width, deep, top + 0.03, 0.07, steel)
    for z in _BOARDS_M:
        solids.append(block(0, 0, z - 0.03, (width - 0.14, deep - 0.06, 0.03), board))
        solids += [block(0, s * (deep - 0.03) / 2, z - 0.1, (width - 0.14, 0.03, 0.1), steel) for s in (-1, 1)]
    return Thing("shelf", tuple(solids))


def _walls(room: Room, placer: Placer) -> None:
    """What hangs on the walls, and the desk of whoever keeps the store."""
    against(placer, room, "west", 0.5, "door")
    against(placer, room, "east", 0.25, "door")
    workplace(placer, room, "south", 0.1)
    against(placer, room, "south", 0.12, "whiteboard", z=1.4)
    against(placer, room, "west", 0.3, "clock", z=2.0)
    against(placer, room, "north", 0.1, "bulletin board", z=1.3)
    for share in (0.35, 0.65):
        window(placer, room, "north", share, 1.6)
    against(placer, room, "east", 0.6, "poster", z=1.4)


def _floor(room: Room, placer: Placer, first_x: float) -> None:
    """Stacks and tools along the walls, carts and ladders at the ends of the rows."""
    for _ in range(8):
        side = SIDES[int(placer.rng.integers(4))]
        stack = against(placer, room, side, float(placer.rng.uniform(0.1, 0.9)), "box", "crate")
        load(placer, stack, "box")
    end_x = first_x + (_RACKS - 0.5) * _RACK_M[0]
    for y in _ROWS_M:
        placer.on_floor(room, piece("cart", placer), end_x + 0.75, y + float(placer.rng.uniform(-0.2, 0.2)), 90)
        placer.on_floor(room, piece("ladder", placer), first_x - _RACK_M[0] / 2 - 0.5, y, 90)
    names = ("fire extinguisher", "fire extinguisher", "recycling bin", "trash can", "ladder", "cart", "bucket")
    scatter(placer, room, *names, "bench", "coat rack", "file cabinet", "radiator", "storage bin", "crate", "fan")


def _camera_path(things: list[Thing], first_x: float) -> CameraPath:
    """Up and down the three lanes, looking at the racks on both sides."""
    near, far = first_x - 2.1, first_x + (_RACKS - 1) * _RACK_M[0] + 2.6
    lanes = (1.7, sum(_ROWS_M) / 2, 8.3)
    path = CameraPath(FreeSpace(EmptyCells.among(things), (near, lanes[0])), (near, lanes[0]))
    path.look((far, lanes[0]))
    for number, y in enumerate(lanes):
        path.go((near if number % 2 == 0 else far, y), _SWAY_DEG / 2)
        path.go((far if number % 2 == 0 else near, y), _SWAY_DEG)
    return path
