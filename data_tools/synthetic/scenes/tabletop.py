"""A table full of small things, and a camera that goes round it near by."""

from __future__ import annotations

from itertools import cycle

import numpy as np
import open3d as o3d

from data_tools.synthetic.camera.walk import Station
from data_tools.synthetic.layout.building import Room, shell
from data_tools.synthetic.layout.finishes import finish, warm_floor
from data_tools.synthetic.layout.free_space import CLEAR_M
from data_tools.synthetic.layout.furnishing import against, piece, scatter, window
from data_tools.synthetic.layout.placement import Placer
from data_tools.synthetic.rendering.ray_renderer import scene_of
from data_tools.synthetic.scenes.world import World
from data_tools.synthetic.shapes.thing import Thing

_ALWAYS = ("laptop", "tray", "bowl", "plate", "book", "potted plant", "tissue box")
_OTHERS = (
    "bottle", "water bottle", "candle", "alarm clock", "headphones", "mouse", "telephone", "stuffed animal", "ball",
    "paper", "coffee kettle", "toaster", "keyboard", "box", "purse", "bowl", "book",
)  # fmt: skip
_THINGS = (18, 23)
_TURNS = 1.0
_BEYOND_M = 0.42
_CLEAR_M = 0.26  # between the eye and the tallest things on the table; a hand's shake comes off it
_LIFTS_M = np.arange(0, 0.8, 0.02)


def tabletop(seed: int) -> World:
    """A dining table with about 20 small things, two or three of them equal cups, in a room with little else; the
    seed varies what stands where, and colours."""
    rng = np.random.default_rng([seed, 41])
    placer = Placer(rng)
    room = Room((0, 0), (float(rng.uniform(4.6, 5.0)), float(rng.uniform(4.2, 4.6))))
    for thing in shell(room, (), finish(warm_floor(rng), rng)):
        placer.add(thing)
    table = placer.on_floor(room, piece("dining table", placer), *room.center)
    assert table is not None
    _set_table(table, placer)
    stations = _clear_of(placer.things, _round(table, rng))
    eyes = np.array([station.eye for station in stations])
    placer.keep_free((eyes.min(axis=0) - CLEAR_M).tolist(), (eyes.max(axis=0) + CLEAR_M).tolist())
    _background(room, placer)
    return World(dict(enumerate(placer.things, start=1)), tuple(stations), placer.relations)


def _set_table(table: Thing, placer: Placer) -> None:
    """Equal cups, what is always there, and others until there are enough."""
    rng = placer.rng
    cup = piece("cup", placer)
    small = [cup] * int(rng.integers(2, 4)) + [piece(name, placer) for name in _ALWAYS]
    n_placed = sum(placer.on_top(table, thing) is not None for thing in small)
    n_wanted = int(rng.integers(*_THINGS))
    for _, name in zip(range(60), cycle(rng.permutation(_OTHERS)), strict=False):
        if n_placed >= n_wanted:
            break
        n_placed += placer.on_top(table, piece(str(name), placer), yaw_deg=float(rng.uniform(0, 360))) is not None


def _background(room: Room, placer: Placer) -> None:
    window(placer, room, "south", 0.4, 0.95, curtains=True)
    against(placer, room, "north", 0.3, "picture", z=1.3)
    against(placer, room, "east", 0.5, "door")
    against(placer, room, "west", 0.4, "poster", z=1.2)
    scatter(placer, room, "cabinet", "plant", "armchair", "lamp", "trash can", "box")


def _round(table: Thing, rng: np.random.Generator) -> list[Station]:
    """Once round the table, rising and sinking, looking at the middle of it."""
    low, high = table.bounds
    middle, half = (low + high) / 2, (high - low) / 2
    start, phase = rng.uniform(0, 2 * np.pi, 2)
    stations = []
    for turn in np.linspace(0, 2 * np.pi * _TURNS, 60):
        angle = start + turn
        out = half[:2] + _BEYOND_M + 0.12 * (1 + np.sin(3 * turn + phase))
        x, y = middle[:2] + out * (np.cos(angle), np.sin(angle))
        eye = (float(x), float(y), float(high[2] + 0.56 + 0.14 * np.sin(2 * turn + phase)))
        at = middle[:2] + 0.3 * half[:2] * (np.cos(2 * angle), np.sin(2 * angle))
        stations.append(Station(eye, (float(at[0]), float(at[1]), float(high[2] + 0.05))))
    return stations


def _clear_of(things: list[Thing], stations: list[Station]) -> list[Station]:
    """The same round, carried higher where it would come too near to what stands on the table."""
    scene, eyes = scene_of(dict(enumerate(things, start=1))), np.array([station.eye for station in stations])
    for lift in _LIFTS_M:
        lifted = np.add(eyes, (0, 0, lift))
        if scene.compute_distance(o3d.core.Tensor.from_numpy(lifted.astype(np.float32))).numpy().min() >= _CLEAR_M:
            break
    rows = zip(lifted.tolist(), stations, strict=True)
    return [Station((x, y, z), station.target) for (x, y, z), station in rows]
