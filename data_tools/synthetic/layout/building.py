"""Rooms with walls, floors and ceilings, and the doorways between them."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np

from data_tools.synthetic.shapes.primitives import block
from data_tools.synthetic.shapes.solids import Material, Point, Solid
from data_tools.synthetic.shapes.thing import Thing

Side = Literal["south", "east", "north", "west"]
SIDES: tuple[Side, ...] = ("south", "east", "north", "west")
DOOR_HEIGHT_M = 2.08
_FRAME_M = 0.06


@dataclass(frozen=True, slots=True)
class Room:
    """A rectangle on the floor between (x, y) corners `low` and `high`, and its height, metres."""

    low: tuple[float, float]
    high: tuple[float, float]
    height: float = 2.6

    @property
    def center(self) -> tuple[float, float]:
        """The middle of the floor."""
        return (self.low[0] + self.high[0]) / 2, (self.low[1] + self.high[1]) / 2

    def along(self, side: Side) -> tuple[float, float]:
        """Where a side starts and ends: in x for south and north, in y for the others."""
        axis = 0 if side in ("south", "north") else 1
        return self.low[axis], self.high[axis]


@dataclass(frozen=True, slots=True)
class Doorway:
    """An opening of `side` between start and end, metres along the wall."""

    side: Side
    start: float
    end: float


@dataclass(frozen=True, slots=True)
class Finish:
    """What the shell of a room is made of; walls in the order of SIDES."""

    floor: Material
    ceiling: Material
    walls: tuple[Material, Material, Material, Material]


def shell(room: Room, doorways: tuple[Doorway, ...], finish: Finish) -> list[Thing]:
    """Floor, ceiling and the four walls of a room, each a thing of its own."""
    (x0, y0), (x1, y1), z = room.low, room.high, room.height
    floor = flat((x0, y0, 0), (x1 - x0, 0, 0), (0, y1 - y0, 0), finish.floor)
    ceiling = flat((x0, y0, z), (0, y1 - y0, 0), (x1 - x0, 0, 0), finish.ceiling)
    return [Thing("floor", (floor,)), Thing("ceiling", (ceiling,)), *walls(room, doorways, finish.walls)]


def walls(room: Room, doorways: tuple[Doorway, ...], paints: Sequence[Material]) -> list[Thing]:
    """The four walls of a room, in the order of SIDES."""
    return [_wall(room, side, doorways, paint) for side, paint in zip(SIDES, paints, strict=True)]


def block_walls(room: Room, paints: Sequence[Material]) -> list[Thing]:
    """The four sides of a block that fills the space of a room, seen from outside, in the order of SIDES."""
    (x0, y0), (x1, y1), up = room.low, room.high, (0.0, 0.0, room.height)
    dx, dy = x1 - x0, y1 - y0
    edges: tuple[tuple[Point, Point], ...] = (
        ((x0, y0, 0), (dx, 0, 0)),
        ((x1, y0, 0), (0, dy, 0)),
        ((x1, y1, 0), (-dx, 0, 0)),
        ((x0, y1, 0), (0, -dy, 0)),
    )
    return [Thing("wall", (flat(o, along, up, p),)) for (o, along), p in zip(edges, paints, strict=True)]


def flat(origin: Point, across: Point, up: Point, material: Material) -> Solid:
    """One rectangle seen from the side of across x up; its texture continues from the world's origin.

    Args:
        origin: the corner where the texture coordinates begin, metres.
        across: the edge along u, metres.
        up: the edge along v, metres.
        material: of its face.
    """
    o, a, b = (np.array(v, float) for v in (origin, across, up))
    u, v = np.linalg.norm(a), np.linalg.norm(b)
    shift = np.array([o.sum() % 3, (2 * o[0] + o[1]) % 3])
    uv = np.array([(0, 0), (u, 0), (u, v), (0, v)]) + shift
    return Solid(np.stack([o, o + a, o + a + b, o + b])[None], uv[None], material)


def _wall(room: Room, side: Side, doorways: tuple[Doorway, ...], paint: Material) -> Thing:
    start, end = room.along(side)
    panels, panel_start = [], start
    for door in sorted((d for d in doorways if d.side == side), key=lambda d: d.start):
        panels.append(_wall_panel(room, side, (panel_start, door.start), (0.0, room.height), paint))
        panels.append(_wall_panel(room, side, (door.start, door.end), (DOOR_HEIGHT_M, room.height), paint))
        panel_start = door.end
    panels.append(_wall_panel(room, side, (panel_start, end), (0.0, room.height), paint))
    return Thing("wall", tuple(panels))


def _wall_panel(room: Room, side: Side, span: tuple[float, float], rise: tuple[float, float], paint: Material) -> Solid:
    (a, b), (low, high) = span, rise
    up = (0.0, 0.0, high - low)
    if side == "south":
        return flat((b, room.low[1], low), (a - b, 0, 0), up, paint)
    if side == "north":
        return flat((a, room.high[1], low), (b - a, 0, 0), up, paint)
    if side == "east":
        return flat((room.high[0], b, low), (0, a - b, 0), up, paint)
    return flat((room.low[0], a, low), (0, b - a, 0), up, paint)


def door_frame(door: Doorway, near: float, far: float, material: Material, floor: Material) -> tuple[Thing, Solid]:
    """The frame that lines a doorway of a south or north wall, and the threshold.

    Args:
        door: the opening.
        near: y of the one side of the wall, metres.
        far: y of the other side.
        material: of the frame.
        floor: of the threshold.
    """
    middle, thick, width = (near + far) / 2, far - near + 0.03, door.end - door.start
    sides = door.start + _FRAME_M / 2 - 0.02, door.end - _FRAME_M / 2 + 0.02
    posts = [block(x, middle, 0.0, (_FRAME_M, thick, DOOR_HEIGHT_M), material) for x in sides]
    head = block((door.start + door.end) / 2, middle, DOOR_HEIGHT_M - 0.02, (width + 0.04, thick, _FRAME_M), material)
    threshold = flat((door.start, near, 0), (width, 0, 0), (0, far - near, 0), floor)
    return Thing("doorframe", (*posts, head)), threshold
