"""A hall with rows of racks full of boxes, pallets, and a walk along the lanes between the rows."""

from __future__ import annotations

from itertools import pairwise

import numpy as np

from data_tools.synthetic.camera.camera_path import CameraPath
from data_tools.synthetic.layout.building import SIDES, Room, Side, shell
from data_tools.synthetic.layout.finishes import concrete_floor, finish
from data_tools.synthetic.layout.free_space import EmptyCells, FreeSpace
from data_tools.synthetic.layout.furnishing import against, along, load, piece, scatter, window, workplace
from data_tools.synthetic.layout.placement import Placer
from data_tools.synthetic.scenes.storage import BOARDS_M, RACK_M, fill_board, load_pallet, pallet, rack
from data_tools.synthetic.scenes.world import World
from data_tools.synthetic.shapes.primitives import block
from data_tools.synthetic.shapes.solids import Solid
from data_tools.synthetic.shapes.thing import Thing, tinted

SIZE_M = (15.0, 10.0)
LEAST_M = (12.0, 8.0)
_HEIGHT_M = 4.2
_FIRST_ROW_M, _BETWEEN_ROWS_M = 3.4, 3.2
_GAP_M = 0.12
_END_M = 2.2
_SWAY_DEG = 50.0
_PALLETS_PER_M = 0.16  # of the length of the walls


def warehouse(seed: int, size_m: tuple[float, float] = SIZE_M) -> World:
    """Rows of equal racks with boxes, bins and crates, loaded pallets along the walls, ladders and carts, and a
    workplace; the seed varies what stands where, and colours. At its usual size two rows and some 100 things.

    Args:
        seed: of everything.
        size_m: length and width, metres, at least LEAST_M.
    """
    rng = np.random.default_rng([seed, 51])
    placer = Placer(rng)
    room = Room((0, 0), size_m, _HEIGHT_M)
    first_x = float(rng.uniform(4.4, 5.2))
    rows_m = np.arange(_FIRST_ROW_M, size_m[1] - _FIRST_ROW_M + 0.01, _BETWEEN_ROWS_M).tolist()
    n_racks = int((size_m[0] - first_x - _END_M) / (RACK_M[0] + _GAP_M))
    end_x = first_x + (n_racks - 0.5) * (RACK_M[0] + _GAP_M)
    floor, *rest = shell(room, (), finish(concrete_floor(rng), rng))
    for thing in (Thing("floor", (*floor.solids, *_marks(rows_m, first_x, end_x))), *rest):
        placer.add(thing)
    _racks(room, placer, rows_m, first_x, n_racks)
    _walls(room, placer)
    _floor(room, placer, rows_m, first_x, end_x)
    path = _camera_path(placer.things, rows_m, size_m[1], (first_x - 2.1, end_x + 1.4))
    return World(dict(enumerate(placer.things, start=1)), tuple(path.stations), placer.relations)


def _marks(rows_m: list[float], first_x: float, end_x: float) -> list[Solid]:
    """Yellow lines on the floor along the rows; they belong to it."""
    paint = tinted("paint", (226.0, 186.0, 60.0), 0.2)
    middle, long = (first_x - RACK_M[0] / 2 + end_x) / 2, end_x - first_x + RACK_M[0] / 2
    return [block(middle, y + s * 0.62, 0, (long, 0.08, 0.001), paint) for y in rows_m for s in (-1, 1)]


def _racks(room: Room, placer: Placer, rows_m: list[float], first_x: float, n_racks: int) -> None:
    empty = rack(placer.rng)
    for y in rows_m:
        for number in range(n_racks):
            put = placer.on_floor(room, empty, first_x + number * (RACK_M[0] + _GAP_M), y)
            if put is not None:
                for height in BOARDS_M:
                    fill_board(placer, put, height)


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
    for side in SIDES:
        against(placer, room, side, 0.45, "sign", z=2.3)


def _floor(room: Room, placer: Placer, rows_m: list[float], first_x: float, end_x: float) -> None:
    """Pallets and tools along the walls, carts and ladders at the ends of the rows."""
    rng = placer.rng
    for _ in range(round(_PALLETS_PER_M * 2 * sum(room.high))):
        side: Side = SIDES[int(rng.integers(4))]
        base = placer.against(room, side, pallet(rng), along(placer, room, side, float(rng.uniform(0.06, 0.94))))
        if base is not None:
            load_pallet(placer, base)
    for y in rows_m:
        placer.on_floor(room, piece("cart", placer), end_x + 0.75, y + float(rng.uniform(-0.2, 0.2)), 90)
        placer.on_floor(room, piece("ladder", placer), first_x - RACK_M[0] / 2 - 0.5, y, 90)
    names = ("fire extinguisher", "fire extinguisher", "recycling bin", "trash can", "ladder", "cart", "bucket")
    scatter(placer, room, *names, "bench", "coat rack", "file cabinet", "radiator", "storage bin", "crate", "fan")
    load(placer, against(placer, room, "west", 0.75, "cabinet"), "box", "basket", "paper bag")


def _camera_path(things: list[Thing], rows_m: list[float], wide: float, ends: tuple[float, float]) -> CameraPath:
    """Up and down the lanes, looking at the racks on both sides."""
    near, far = ends
    lanes = [rows_m[0] / 2, *(float(np.mean(pair)) for pair in pairwise(rows_m))]
    lanes.append((rows_m[-1] + wide) / 2)
    path = CameraPath(FreeSpace(EmptyCells.among(things), (near, lanes[0])), (near, lanes[0]))
    path.look((far, lanes[0]))
    for number, y in enumerate(lanes):
        path.go((near if number % 2 == 0 else far, y), _SWAY_DEG / 2)
        path.go((far if number % 2 == 0 else near, y), _SWAY_DEG)
    return path
