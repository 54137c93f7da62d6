"""A corridor round a block, with three places that look alike, and a walk once round."""

from __future__ import annotations

import numpy as np

from data_tools.synthetic.camera.camera_path import CameraPath
from data_tools.synthetic.layout.building import SIDES, Room, Side, block_walls, flat, walls
from data_tools.synthetic.layout.finishes import finish, tiled_floor, warm_floor
from data_tools.synthetic.layout.free_space import EmptyCells, FreeSpace
from data_tools.synthetic.layout.furnishing import load, piece
from data_tools.synthetic.layout.placement import Placer
from data_tools.synthetic.objects.catalogue import PIECES
from data_tools.synthetic.scenes.world import World
from data_tools.synthetic.shapes.thing import Thing

_WIDE_M = 1.9
_WAY_M = (0.9, 1.76)  # from the outer wall
_SWAY_DEG = 22.0
_FORWARD: dict[Side, float] = {"south": 1.0, "east": 1.0, "north": -1.0, "west": -1.0}
_OPPOSITE: dict[Side, Side] = {"south": "north", "east": "west", "north": "south", "west": "east"}
_ON_FLOORS = (
    "radiator", "box", "bench", "trash can", "fire extinguisher", "radiator", "recycling bin", "box", "coat rack",
    "bucket", "stool", "storage bin", "radiator", "file cabinet", "cabinet", "suitcase", "ladder",
)  # fmt: skip
_ON_WALLS = (
    "bulletin board", "clock", "poster", "picture", "mirror", "whiteboard", "poster", "picture", "blackboard",
)  # fmt: skip


def corridor_loop(seed: int) -> World:
    """A ring of about 28 m with some 40 things and bare walls between them; the seed varies sizes, what stands
    where, and colours, and at which side the three look-alike places are not."""
    rng = np.random.default_rng([seed, 31])
    size = (float(rng.uniform(9.4, 9.9)), float(rng.uniform(8.0, 8.6)))
    placer = Placer(rng)
    _build(size, placer)
    legs = _legs(size)
    for side, leg in legs.items():
        placer.keep_free(*_way(leg, side))
    _look_alikes(legs, placer)
    _furnish(legs, placer)
    return World(dict(enumerate(placer.things, start=1)), tuple(_tour(size, placer.things).stations), placer.relations)


def _build(size: tuple[float, float], placer: Placer) -> None:
    x, y, w = *size, _WIDE_M
    ring, block = Room((0, 0), size), Room((w, w), (x - w, y - w))
    rng = placer.rng
    look = finish((tiled_floor if rng.uniform() < 0.5 else warm_floor)(rng), rng)
    strips = (((0, 0), (x, w)), ((0, y - w), (x, y)), ((0, w), (w, y - w)), ((x - w, w), (x, y - w)))
    floor = [flat((a, b, 0), (c - a, 0, 0), (0, d - b, 0), look.floor) for (a, b), (c, d) in strips]
    ceiling = [flat((a, b, ring.height), (0, d - b, 0), (c - a, 0, 0), look.ceiling) for (a, b), (c, d) in strips]
    for thing in (Thing("floor", tuple(floor)), Thing("ceiling", tuple(ceiling))):
        placer.add(thing)
    for thing in walls(ring, (), look.walls) + block_walls(block, finish(look.floor, rng).walls):
        placer.add(thing)


def _legs(size: tuple[float, float]) -> dict[Side, Room]:
    """The four straight pieces, named by the side of their outer wall; they share their corners."""
    x, y, w = *size, _WIDE_M
    return {
        "south": Room((0, 0), (x, w)),
        "east": Room((x - w, 0), (x, y)),
        "north": Room((0, y - w), (x, y)),
        "west": Room((0, 0), (w, y)),
    }


def _way(leg: Room, side: Side) -> tuple[list[float], list[float]]:
    """The box that a camera needs to pass between plants at the outer wall and the block."""
    low, high = [*leg.low, 1.0], [*leg.high, 1.95]
    axis, (near, far) = (1 if side in ("south", "north") else 0), _WAY_M
    if side in ("south", "west"):
        low[axis], high[axis] = low[axis] + near, low[axis] + far
    else:
        low[axis], high[axis] = high[axis] - far, high[axis] - near
    return low, high


def _look_alikes(legs: dict[Side, Room], placer: Placer) -> None:
    """The same door, picture and plant at the outer walls of three of the four sides, another door at the fourth."""
    rng = placer.rng
    door, picture, plant = piece("door", placer), piece("picture", placer), piece("plant", placer)
    while np.subtract(*plant.bounds[::-1])[:2].max() > 0.85:
        plant = piece("plant", placer)
    odd_side = SIDES[int(rng.integers(4))]
    for side, leg in legs.items():
        start, end = leg.along(side)
        middle, forward = (start + end) / 2, _FORWARD[side]
        if side == odd_side:
            placer.against(leg, side, piece("door", placer), middle + 0.4)
            continue
        placer.against(leg, side, door, middle)
        placer.against(leg, side, picture, middle + forward * 1.25, 1.35, gap=0.0)
        placer.against(leg, side, plant, middle - forward * 1.1)


def _furnish(legs: dict[Side, Room], placer: Placer) -> None:
    for names, raised in ((_ON_WALLS, True), (_ON_FLOORS, False)):
        for name in placer.rng.permutation(names)[: len(names) - 2]:
            for _ in range(12):
                put = _put_anywhere(legs, placer, str(name), raised)
                if put is not None:
                    if put.class_name in ("cabinet", "file cabinet", "bench"):
                        load(placer, put, "potted plant", "box", "book")
                    break


def _put_anywhere(legs: dict[Side, Room], placer: Placer, name: str, raised: bool) -> Thing | None:
    """A new piece at a random place of a random wall; None where it has no room there."""
    rng = placer.rng
    leg_side = SIDES[int(rng.integers(4))]
    leg = legs[leg_side]
    side = leg_side if rng.uniform() < 0.5 else _OPPOSITE[leg_side]
    # The block's wall is shorter than the outer one by a corridor at each end.
    start, end = np.add(leg.along(side), (_WIDE_M + 0.6, -_WIDE_M - 0.6))
    z = float(rng.uniform(1.2, 1.5)) if raised else 0.0
    gap = 0.0 if raised else 0.005
    return placer.against(leg, side, PIECES[name](rng), float(rng.uniform(start, end)), z, gap)


def _tour(size: tuple[float, float], things: list[Thing]) -> CameraPath:
    """Once round against the clock, from the middle of the south side and back to it."""
    x, y, half = *size, _WIDE_M / 2
    start = (x / 2, half)
    # What leans on the outer wall may come near to the start; the way past it is free.
    path = CameraPath(FreeSpace(EmptyCells.among(things), start, reach_m=half), start)
    path.look((x, half))
    for corner in ((x - half, half), (x - half, y - half), (half, y - half), (half, half), start):
        path.go(corner, _SWAY_DEG)
    path.look((x, half))
    return path
