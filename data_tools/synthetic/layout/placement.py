"""Collision-free placement: on the floor, against walls, on top of each other, never into each other."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import open3d as o3d

from data_tools.synthetic.layout.arrangement import Arrangement, Triple
from data_tools.synthetic.layout.building import Room, Side
from data_tools.synthetic.rendering.ray_renderer import scene_of
from data_tools.synthetic.shapes.thing import Thing
from razer.arrays import Float64Array

YAW_DEG: dict[Side, float] = {"south": 0.0, "east": 90.0, "north": 180.0, "west": -90.0}
_TOUCH_M = 0.004
_WALL_GAP_M = 0.005
_LEVEL_M = 0.004
_FOOT_M = 0.003
_ROUNDING_M = 1e-6
_TRIES = 40

Area = tuple[Float64Array, Float64Array]


class Placer:
    """The things of a world in order, and where there is room for more; the rng decides what is left open."""

    def __init__(self, rng: np.random.Generator) -> None:
        self.rng = rng
        self.arrangement = Arrangement()
        self._boxes: Float64Array = np.zeros((0, 2, 3))

    @property
    def things(self) -> list[Thing]:
        """All things so far."""
        return self.arrangement.things

    @property
    def relations(self) -> tuple[Triple, ...]:
        """What was put on, into or against what: (id, relation, id), ids from 1 in the order of the things."""
        return tuple(self.arrangement.relations)

    def add(self, thing: Thing) -> Thing:
        """Take a thing where it is, whatever else is there."""
        self.things.append(thing)
        self._boxes = np.concatenate([self._boxes, solid_boxes(thing)])
        return thing

    def keep_free(self, low: Sequence[float], high: Sequence[float]) -> None:
        """Let nothing stand in a box, such as the way through a door."""
        self._boxes = np.concatenate([self._boxes, np.array([[low, high]], float)])

    def try_add(self, thing: Thing) -> Thing | None:
        """Take a thing if it cuts into nothing that is there."""
        return None if self.collides(thing) else self.add(thing)

    def collides(self, thing: Thing) -> bool:
        """Whether the box of any solid of the thing cuts into that of another thing's, by more than a touch."""
        return self._cuts(solid_boxes(thing))

    def _cuts(self, own: Float64Array) -> bool:
        low, high = own[:, 0].min(axis=0), own[:, 1].max(axis=0)
        near = ((self._boxes[:, 0] < high) & (self._boxes[:, 1] > low)).all(axis=1)
        boxes = self._boxes[near]
        overlap = np.minimum(own[:, None, 1], boxes[:, 1]) - np.maximum(own[:, None, 0], boxes[:, 0])
        return bool((overlap > _TOUCH_M).all(axis=2).any())

    def against(
        self, room: Room, side: Side, thing: Thing, along: float, z: float = 0.0, gap: float = _WALL_GAP_M
    ) -> Thing | None:
        """Put the back of a thing to a wall of the room; None where it does not fit.

        Args:
            room: where.
            side: the wall.
            thing: what.
            along: where its middle is to be, metres along the wall.
            z: height of its lower edge, metres.
            gap: between its back and the wall, metres.
        """
        turned = thing.placed(0, 0, 0, YAW_DEG[side])
        low, high = turned.bounds
        wall = {"south": room.low[1], "east": room.high[0], "north": room.high[1], "west": room.low[0]}[side]
        if side in ("south", "north"):
            y = wall + gap - low[1] if side == "south" else wall - gap - high[1]
            put = turned.placed(along - (low[0] + high[0]) / 2, y, z)
        else:
            x = wall + gap - low[0] if side == "west" else wall - gap - high[0]
            put = turned.placed(x, along - (low[1] + high[1]) / 2, z)
        if not _inside(room, put) or self.try_add(put) is None:
            return None
        (self.arrangement.hangs if z > 0 else self.arrangement.stands)(put)
        return put

    def on_floor(self, room: Room, thing: Thing, x: float, y: float, yaw_deg: float = 0.0) -> Thing | None:
        """Stand a thing on the floor of a room; None where it does not fit.

        Args:
            room: where.
            thing: what.
            x: metres.
            y: metres.
            yaw_deg: by which it is turned about the vertical.
        """
        put = thing.placed(x, y, 0.0, yaw_deg)
        if not _inside(room, put) or self.try_add(put) is None:
            return None
        self.arrangement.stands(put)
        return put

    def on_top(
        self,
        support: Thing,
        thing: Thing,
        *,
        level: int = 0,
        yaw_deg: float | None = None,
        area: Area | None = None,
        margin: float = 0.01,
    ) -> Thing | None:
        """Stand a thing on a support at a random place; None where no place tried is level, wide enough and free.

        Args:
            support: what it stands on.
            thing: what.
            level: which surface of the support, 0 = the highest.
            yaw_deg: by which it is turned; None = by up to 30 degrees at random.
            area: corners (x, y) within which it stands; None = the whole support.
            margin: between its foot and the rim, metres.
        """
        tops = _Tops(support)
        low, high = area or (support.bounds[0][:2], support.bounds[1][:2])
        turned = thing.placed(0, 0, 0, yaw_deg or 0.0)
        for _ in range(_TRIES):
            if yaw_deg is None:
                turned = thing.placed(0, 0, 0, float(self.rng.uniform(-30, 30)))
            foot_low, foot_high = _foot(turned)
            lowest, highest = low - foot_low, high - foot_high
            if (lowest > highest).any():
                continue
            at = self.rng.uniform(lowest, highest)
            height = tops.level_under(foot_low + at - margin, foot_high + at + margin, level)
            if height is not None and not self._cuts(solid_boxes(turned) + np.array([*at, height])):
                put = self.add(turned.placed(float(at[0]), float(at[1]), height))
                self.arrangement.rests(put, support)
                return put
        return None


class _Tops:
    """The upper surfaces of one thing, found by rays from above."""

    def __init__(self, thing: Thing) -> None:
        self._scene = scene_of({1: thing})
        self._above = float(thing.bounds[1][2]) + 0.1

    def level_under(self, low: Float64Array, high: Float64Array, level: int) -> float | None:
        """The height of the surface number `level` from above if it is level under a rectangle; else None."""
        x, y = np.meshgrid(np.linspace(low[0], high[0], 4), np.linspace(low[1], high[1], 4))
        heights = self._heights(np.column_stack([x.ravel(), y.ravel()]), level)
        flat = np.isfinite(heights).all() and np.ptp(heights) <= _LEVEL_M
        return float(heights.max()) if flat else None

    def _heights(self, points: Float64Array, level: int) -> Float64Array:
        rays = np.zeros((len(points), 6), np.float32)
        rays[:, :2], rays[:, 2], rays[:, 5] = points, self._above, -1
        up_faces = -1
        while True:
            hit = self._scene.cast_rays(o3d.core.Tensor.from_numpy(rays))
            rays[:, 2] -= hit["t_hit"].numpy() + np.float32(1e-3)
            if not np.isfinite(rays[:, 2]).all():
                return np.full(len(points), np.nan)
            up_faces += bool((hit["primitive_normals"].numpy()[:, 2] > 0.9).all())
            if up_faces == level:
                return (rays[:, 2] + 1e-3).astype(np.float64)


def strip(thing: Thing, side: Side, near: float, far: float) -> Area:
    """The part of a thing's ground plan between two shares of its depth, as two corners (x, y).

    Args:
        thing: whose ground plan.
        side: the wall it stands at.
        near: share of its depth, 0 = its edge at the wall.
        far: share of its depth, 1 = the opposite edge.
    """
    low, high = thing.bounds[0][:2].copy(), thing.bounds[1][:2].copy()
    axis = 1 if side in ("south", "north") else 0
    if side in ("east", "north"):
        near, far = 1 - far, 1 - near
    start, deep = float(low[axis]), float(high[axis] - low[axis])
    low[axis], high[axis] = start + near * deep, start + far * deep
    return low, high


def _foot(thing: Thing) -> Area:
    """The rectangle round what a thing stands on: lowest and highest corner (2,)."""
    points = np.concatenate([solid.quads for solid in thing.solids]).reshape(-1, 3)
    feet = points[points[:, 2] < points[:, 2].min() + _FOOT_M, :2]
    return feet.min(axis=0), feet.max(axis=0)


def _inside(room: Room, thing: Thing) -> bool:
    low, high = thing.bounds
    lowest, highest = np.array(room.low) - _ROUNDING_M, np.array(room.high) + _ROUNDING_M
    return bool((low[:2] >= lowest).all() and (high[:2] <= highest).all() and high[2] <= room.height + _ROUNDING_M)


def solid_boxes(thing: Thing) -> Float64Array:
    """The axis-aligned boxes (S, 2, 3) of the solids of a thing: lowest and highest corners."""
    return np.stack([[s.quads.min(axis=(0, 1)), s.quads.max(axis=(0, 1))] for s in thing.solids])
