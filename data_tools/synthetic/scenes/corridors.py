"""Corridors of an office floor round blocks of rooms, with doors, signs and extinguishers, and a walk along them."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from data_tools.synthetic.camera.camera_path import CameraPath
from data_tools.synthetic.camera.walk import Station
from data_tools.synthetic.layout.building import SIDES, Finish, Room, Side, block_walls, flat, walls
from data_tools.synthetic.layout.finishes import finish, tiled_floor, warm_floor
from data_tools.synthetic.layout.free_space import EmptyCells, FreeSpace
from data_tools.synthetic.layout.furnishing import load, piece
from data_tools.synthetic.layout.placement import Placer
from data_tools.synthetic.scenes.world import World
from data_tools.synthetic.shapes.thing import Thing

SIZE_M = (24.0, 14.0)
LEAST_M = (9.0, 9.0)
_WIDE_M = 2.1
_BLOCK_M = (8.5, 6.0)  # about
_DOORS_M = 3.3
_SWAY_DEG = 26.0
_OPPOSITE: dict[Side, Side] = {"south": "north", "east": "west", "north": "south", "west": "east"}
_ON_FLOORS = ("bench", "trash can", "plant", "chair", "recycling bin", "radiator", "cabinet", "box")
_ON_WALLS = ("picture", "bulletin board", "poster", "clock", "whiteboard", "picture")


@dataclass(frozen=True, slots=True)
class _Plan:
    """The blocks between the corridors, and the middles of the corridors along x and along y."""

    blocks: list[Room]
    across: list[float]
    along: list[float]


def corridors(seed: int, size_m: tuple[float, float] = SIZE_M) -> World:
    """Corridors 2.1 m wide round blocks of rooms with doors every few metres, name plates, signs, extinguishers,
    benches and boards; the seed varies colours and what stands where.

    Args:
        seed: of everything.
        size_m: length and width of the floor, metres, at least LEAST_M.
    """
    rng = np.random.default_rng([seed, 71])
    placer = Placer(rng)
    plan = _plan(size_m)
    floor = tiled_floor(rng) if rng.uniform() < 0.5 else warm_floor(rng)
    look, inner = finish(floor, rng), finish(floor, rng).walls
    for thing in (*_floor_and_ceiling(plan, size_m, look), *walls(Room((0, 0), size_m), (), look.walls)):
        placer.add(thing)
    for one in plan.blocks:
        for wall in block_walls(one, inner):
            placer.add(wall)
    for one in plan.blocks:
        for side in SIDES:
            _keep_way(placer, _beside(one, side), side)
    door = piece("door", placer)
    for one in plan.blocks:
        for side in SIDES:
            space = _beside(one, side)
            _furnish(placer, space, _OPPOSITE[side], door)
            if _is_outer(space, side, size_m):
                _furnish(placer, space, side, door)
    return World(dict(enumerate(placer.things, start=1)), tuple(_tour(plan, placer.things)), placer.relations)


def _plan(size_m: tuple[float, float]) -> _Plan:
    starts, sizes, middles = [], [], []
    for total, usual in zip(size_m, _BLOCK_M, strict=True):
        count = max(1, round((total - _WIDE_M) / (usual + _WIDE_M)))
        pitch = (total - _WIDE_M) / count
        starts.append(_WIDE_M + pitch * np.arange(count))
        sizes.append(pitch - _WIDE_M)
        middles.append((_WIDE_M / 2 + pitch * np.arange(count + 1)).tolist())
    blocks = [
        Room((float(x), float(y)), (float(x + sizes[0]), float(y + sizes[1]))) for x in starts[0] for y in starts[1]
    ]
    return _Plan(blocks, *middles)


def _floor_and_ceiling(plan: _Plan, size_m: tuple[float, float], look: Finish) -> list[Thing]:
    """The floor and the ceiling of the corridors, without what lies within the blocks."""
    half = _WIDE_M / 2
    strips = [((0.0, y - half), (size_m[0], y + half)) for y in plan.along]
    strips += [
        ((x - half, low + half), (x + half, high - half)) for x in plan.across for low, high in pairwise(plan.along)
    ]
    up = Room((0, 0), size_m).height
    floor = [flat((a, b, 0), (c - a, 0, 0), (0, d - b, 0), look.floor) for (a, b), (c, d) in strips]
    ceiling = [flat((a, b, up), (0, d - b, 0), (c - a, 0, 0), look.ceiling) for (a, b), (c, d) in strips]
    return [Thing("floor", tuple(floor)), Thing("ceiling", tuple(ceiling))]


def _beside(one: Room, side: Side) -> Room:
    """The stretch of corridor along a side of a block."""
    (x0, y0), (x1, y1), w = one.low, one.high, _WIDE_M
    return {
        "south": Room((x0, y0 - w), (x1, y0)),
        "north": Room((x0, y1), (x1, y1 + w)),
        "west": Room((x0 - w, y0), (x0, y1)),
        "east": Room((x1, y0), (x1 + w, y1)),
    }[side]


def _is_outer(space: Room, side: Side, size_m: tuple[float, float]) -> bool:
    """Whether the stretch at this side of a block lies along the outer wall."""
    axis = 0 if side in ("west", "east") else 1
    edge = space.low[axis] if side in ("south", "west") else size_m[axis] - space.high[axis]
    return abs(edge) < 1e-6


def _keep_way(placer: Placer, space: Room, side: Side) -> None:
    """Keep the middle of a stretch free for the camera."""
    low, high = [*space.low, 1.0], [*space.high, 1.95]
    axis = 1 if side in ("south", "north") else 0
    middle = (low[axis] + high[axis]) / 2
    low[axis], high[axis] = middle - 0.45, middle + 0.45
    placer.keep_free(low, high)


def _furnish(placer: Placer, space: Room, side: Side, door: Thing) -> None:
    """Doors at even distances along a wall, a plate beside each, and something between two of them."""
    rng = placer.rng
    start, end = space.along(side)
    count = max(1, int((end - start) / _DOORS_M))
    step = (end - start) / count
    for number in range(count):
        at = start + (number + 0.5) * step + float(rng.uniform(-0.15, 0.15))
        if placer.against(space, side, door, at) is None:
            continue
        placer.against(space, side, piece("sign", placer), at + 0.72, 1.45, gap=0.0)
        if number % 2 == 0 and placer.against(space, side, piece("fire extinguisher", placer), at - 0.75):
            placer.against(space, side, piece("sign", placer), at - 0.75, 1.6, gap=0.0)
        if number < count - 1:
            _between(placer, space, side, at + step / 2)
    if rng.uniform() < 0.5:
        placer.against(space, side, piece("sign", placer), start + 0.5, 2.25, gap=0.0)


def _between(placer: Placer, space: Room, side: Side, at: float) -> None:
    rng = placer.rng
    if rng.uniform() < 0.6:
        put = placer.against(space, side, piece(str(rng.choice(_ON_FLOORS)), placer), at)
        if put is not None and put.class_name == "cabinet":
            load(placer, put, "potted plant", "book")
    else:
        placer.against(space, side, piece(str(rng.choice(_ON_WALLS)), placer), at, 1.3, gap=0.0)


def _tour(plan: _Plan, things: list[Thing]) -> list[Station]:
    """Along all corridors of one direction in turn, then along those of the other, ending where it began."""
    start = (plan.across[0] + _WIDE_M, plan.along[0])
    path = CameraPath(FreeSpace(EmptyCells.among(things), start), start)
    path.look((plan.across[-1], plan.along[0]))
    for number, y in enumerate(plan.along):
        ends = plan.across[:: -1 if number % 2 else 1]
        path.go((ends[0], y), _SWAY_DEG / 2)
        path.go((ends[-1], y), _SWAY_DEG)
    last_is_right = len(plan.along) % 2 == 1
    for number, x in enumerate(plan.across[:: -1 if last_is_right else 1]):
        ends = plan.along[:: 1 if number % 2 else -1]
        path.go((x, ends[0]), _SWAY_DEG / 2)
        path.go((x, ends[-1]), _SWAY_DEG)
    path.go(start, _SWAY_DEG / 2)
    path.look((plan.across[-1], plan.along[0]))
    return path.stations
