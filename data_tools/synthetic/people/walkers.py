"""Ways of people through a world: to and fro between places that are free, and out of the camera's way."""

from __future__ import annotations

from collections.abc import Mapping
from contextlib import suppress
from dataclasses import dataclass

import numpy as np

from data_tools.synthetic.layout.free_space import EmptyCells, FreeSpace
from data_tools.synthetic.people.figure import Figure
from data_tools.synthetic.shapes.thing import Thing
from razer.arrays import Float64Array

SPEED_M_PER_S = 0.8
STRIDE_M = 1.3  # two steps
_BODY_M = (0.05, 1.95)
_CLEAR_M = 0.33
_NEAR_M = 0.9
_FAR_M = 6.0
_WAY_M = (2.0, 12.0)
_TRIES = 40


@dataclass(frozen=True, slots=True)
class Walker:
    """Somebody, the way (K, 2) in metres on the floor that they walk to and fro, and where on it they begin, metres."""

    figure: Figure
    way: Float64Array
    begin_m: float

    def at(self, time_s: float) -> tuple[Float64Array, float]:
        """Where they are, world_from_person (4, 4), and the point 0..1 of their stride."""
        steps = np.linalg.norm(np.diff(self.way, axis=0), axis=1)
        along = np.concatenate([[0.0], np.cumsum(steps)])
        walked = self.begin_m + SPEED_M_PER_S * time_s
        there = walked % (2 * along[-1])
        place = along[-1] - abs(there - along[-1])
        ahead = 0.3 if there < along[-1] else -0.3
        here, next_ = (_on(self.way, along, min(max(s, 0.0), along[-1])) for s in (place, place + ahead))
        if np.linalg.norm(next_ - here) < 1e-3:
            next_, here = here, _on(self.way, along, place - ahead)
        heading = np.arctan2(*(next_ - here)[::-1]) - np.pi / 2
        pose = np.eye(4)
        pose[:2, :2] = [[np.cos(heading), -np.sin(heading)], [np.sin(heading), np.cos(heading)]]
        pose[:2, 3] = _on(self.way, along, place)
        return pose, walked / STRIDE_M % 1.0


def walkers(
    things: Mapping[int, Thing], poses: Float64Array, frames_per_s: float, count: int, seed: int
) -> tuple[Walker, ...]:
    """People who walk where the camera comes by, and keep away from it; fewer than asked where there is no room.

    Args:
        things: instance id -> Thing.
        poses: (N, 4, 4) world_from_camera.
        frames_per_s: of the poses.
        count: how many people.
        seed: of who they are and where they walk.
    """
    if not count:
        return ()
    rng = np.random.default_rng([seed, 81])
    space = _space(EmptyCells.among(things.values(), _BODY_M), poses)
    if space is None:
        return ()
    found: list[Walker] = []
    for _ in range(_TRIES * count):
        if len(found) == count:
            break
        walker = _walker(space, poses, rng)
        if walker is not None and _keeps_away(walker, poses, frames_per_s):
            found.append(walker)
    return tuple(found)


def _space(cells: EmptyCells, poses: Float64Array) -> FreeSpace | None:
    """Where people can walk and come by where the camera is; None where it is nowhere above free floor."""
    for place in poses[:: max(1, len(poses) // _TRIES), :2, 3]:
        with suppress(ValueError):
            return FreeSpace(cells, place, _CLEAR_M)
    return None


def _walker(space: FreeSpace, poses: Float64Array, rng: np.random.Generator) -> Walker | None:
    """Somebody who crosses what the camera sees somewhere on its way."""
    pose = poses[int(rng.integers(len(poses)))]
    ahead = pose[:2, 2] / max(float(np.linalg.norm(pose[:2, 2])), 1e-6)
    middle = pose[:2, 3] + rng.uniform(1.5, _FAR_M) * ahead
    ends = [space.nearest(middle + rng.uniform(-3, 3, 2)) for _ in range(2)]
    if np.linalg.norm(ends[0] - ends[1]) < _WAY_M[0]:
        return None
    way = space.route(*ends)
    long = float(np.linalg.norm(np.diff(way, axis=0), axis=1).sum())
    return Walker(Figure.of(rng), way, float(rng.uniform(0, 2 * long))) if _WAY_M[0] < long < _WAY_M[1] else None


def _keeps_away(walker: Walker, poses: Float64Array, frames_per_s: float) -> bool:
    places = np.array([walker.at(index / frames_per_s)[0][:2, 3] for index in range(len(poses))])
    return bool(np.linalg.norm(places - poses[:, :2, 3], axis=1).min() > _NEAR_M)


def _on(way: Float64Array, along: Float64Array, place: float) -> Float64Array:
    """The point (2,) of a way at a length along it."""
    return np.array([np.interp(place, along, way[:, k]) for k in range(2)])
