"""An apartment of five rooms along a hall, and a walk through all of them."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from data_tools.synthetic.camera.camera_path import CameraPath
from data_tools.synthetic.camera.walk import Station
from data_tools.synthetic.layout.building import DOOR_HEIGHT_M, Doorway, Room, door_frame, shell
from data_tools.synthetic.layout.finishes import finish, tiled_floor, warm_floor
from data_tools.synthetic.layout.free_space import EmptyCells, FreeSpace
from data_tools.synthetic.layout.placement import Placer
from data_tools.synthetic.scenes import apartment_rooms as rooms
from data_tools.synthetic.scenes.world import World
from data_tools.synthetic.shapes.materials import lacquer
from data_tools.synthetic.shapes.solids import Material
from data_tools.synthetic.shapes.thing import Thing

_WALL_M = 0.2  # between two rooms; thinner ones let a Kinect's noise reach through
_TILED = ("kitchen", "bathroom")


@dataclass(frozen=True, slots=True)
class Plan:
    """The rooms by name and where their doors to the hall are, along x."""

    rooms: dict[str, Room]
    doors: dict[str, Doorway]


def apartment(seed: int) -> World:
    """About 100 things of more than 40 classes; the seed varies plan, furniture, places and colours."""
    rng = np.random.default_rng([seed, 11])
    plan = _plan(rng)
    placer = Placer(rng)
    _build(plan, placer)
    for furnish, name in (
        (rooms.living_room, "living"),
        (rooms.kitchen, "kitchen"),
        (rooms.bedroom, "bedroom"),
        (rooms.bathroom, "bathroom"),
        (rooms.study, "study"),
        (rooms.hall, "hall"),
    ):
        furnish(plan.rooms[name], placer)
    return World(dict(enumerate(placer.things, start=1)), tuple(_tour(plan, placer.things)), placer.relations)


def _plan(rng: np.random.Generator) -> Plan:
    """South of the hall living room and kitchen, north of it bedroom, bathroom and study."""
    living_x, kitchen_x = rng.uniform(4.7, 5.1), rng.uniform(3.0, 3.4)
    width = living_x + _WALL_M + kitchen_x
    bedroom_x, bath_x = rng.uniform(3.5, 3.8), rng.uniform(1.8, 2.0)
    south, hall = rng.uniform(3.9, 4.2), rng.uniform(1.3, 1.45)
    north = south + hall + 2 * _WALL_M
    study_x = bedroom_x + bath_x + 2 * _WALL_M
    spaces = {
        "living": Room((0, 0), (living_x, south)),
        "kitchen": Room((living_x + _WALL_M, 0), (width, south)),
        "hall": Room((0, south + _WALL_M), (width, south + _WALL_M + hall)),
        "bedroom": Room((0, north), (bedroom_x, north + rng.uniform(3.4, 3.7))),
        "bathroom": Room((bedroom_x + _WALL_M, north), (bedroom_x + _WALL_M + bath_x, north + rng.uniform(2.4, 2.7))),
        "study": Room((study_x, north), (width, north + rng.uniform(3.1, 3.4))),
    }
    starts = {"living": 1.9, "kitchen": 1.2, "bedroom": 2.2, "bathroom": 0.5, "study": 0.7}
    doors = {
        name: Doorway(
            "north" if name in ("living", "kitchen") else "south",
            spaces[name].low[0] + start,
            spaces[name].low[0] + start + (0.9 if name == "bathroom" else 1.0),
        )
        for name, start in starts.items()
    }
    return Plan(spaces, doors)


def _build(plan: Plan, placer: Placer) -> None:
    rng = placer.rng
    floors = {n: (tiled_floor if n in _TILED else warm_floor)(rng) for n in plan.rooms}
    frame = lacquer(rng)
    shells = _shells(plan, floors, rng)
    hall_floor = 6 * list(plan.rooms).index("hall")
    for name, door in plan.doors.items():
        room, hall = plan.rooms[name], plan.rooms["hall"]
        near, far = sorted((room.high[1], hall.low[1]) if door.side == "north" else (hall.high[1], room.low[1]))
        thing, threshold = door_frame(door, near, far, frame, floors["hall"])
        shells.append(thing)
        shells[hall_floor] = Thing("floor", (*shells[hall_floor].solids, threshold))
        placer.keep_free((door.start, near - 0.7, 0), (door.end, far + 0.7, DOOR_HEIGHT_M))
    for thing in shells:
        placer.add(thing)
    for thing in shells:
        if thing.class_name == "doorframe":
            placer.arrangement.stands(thing)


def _shells(plan: Plan, floors: Mapping[str, Material], rng: np.random.Generator) -> list[Thing]:
    """Floor, ceiling and four walls of each room, in the order of the rooms."""
    into_hall = tuple(_seen_from_hall(door) for door in plan.doors.values())
    shells: list[Thing] = []
    for name, room in plan.rooms.items():
        shells += shell(room, into_hall if name == "hall" else (plan.doors[name],), finish(floors[name], rng))
    return shells


def _seen_from_hall(door: Doorway) -> Doorway:
    return Doorway("south" if door.side == "north" else "north", door.start, door.end)


def _tour(plan: Plan, things: list[Thing]) -> list[Station]:
    """Along the hall into each room, round it, and back, ending where it began."""
    hall = plan.rooms["hall"]
    y = hall.center[1]
    start = (1.2, y)
    path = CameraPath(FreeSpace(EmptyCells.among(things), (hall.center[0], y)), start)
    path.look((3.5, y))
    for name in ("living", "kitchen", "study", "bathroom", "bedroom"):
        door, room = plan.doors[name], plan.rooms[name]
        x = (door.start + door.end) / 2
        inside = room.high[1] - 0.5 if door.side == "north" else room.low[1] + 0.5
        path.go((x, inside))
        path.round(room.low, room.high, reach=0.35)
    path.go(start)
    path.look((3.5, y))
    return path.stations
