"""Two rooms off a hall, furnished alike to the centimetre, and a walk through both: a place that repeats itself."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from data_tools.synthetic.camera.camera_path import CameraPath
from data_tools.synthetic.camera.walk import Station
from data_tools.synthetic.layout.building import DOOR_HEIGHT_M, Doorway, Room, door_frame, shell
from data_tools.synthetic.layout.finishes import finish, warm_floor
from data_tools.synthetic.layout.free_space import EmptyCells, FreeSpace
from data_tools.synthetic.layout.furnishing import scatter
from data_tools.synthetic.layout.placement import Placer
from data_tools.synthetic.scenes import apartment_rooms as rooms
from data_tools.synthetic.scenes.world import World
from data_tools.synthetic.shapes.materials import lacquer
from data_tools.synthetic.shapes.solids import Colour, Solid
from data_tools.synthetic.shapes.thing import Thing

_WALL_M = 0.2
_DOOR_M = (1.9, 2.9)  # from the western end of each room
_N_SHELL = 6  # floor, ceiling and walls of a room
_DYED = 0.25  # share of the things of the second room that have another colour
_DYE = (0.55, 1.0)  # the factors of red, green and blue
_ALONE = ("suitcase", "laundry basket")  # what stands in one of the rooms only


def twin_rooms(seed: int) -> World:
    """Two living rooms of some 40 things each and a hall: the second is the first, moved, but for the colours of a
    quarter of its things and one piece in each; the seed varies sizes, furniture and colours."""
    rng = np.random.default_rng([seed, 61])
    placer = Placer(rng)
    west = Room((0, 0), (float(rng.uniform(4.7, 5.1)), float(rng.uniform(3.9, 4.2))))
    apart = west.high[0] + _WALL_M
    east = Room((apart, 0), (apart + west.high[0], west.high[1]))
    hall = Room((0, west.high[1] + _WALL_M), (east.high[0], west.high[1] + _WALL_M + float(rng.uniform(1.3, 1.45))))
    doors = [Doorway("north", room.low[0] + _DOOR_M[0], room.low[0] + _DOOR_M[1]) for room in (west, east)]
    _build(placer, west, hall, doors, apart)
    first = len(placer.things)
    rooms.living_room(west, placer)
    _repeat(placer, first, apart)
    rooms.hall(hall, placer)
    for room, name in zip((west, east), _ALONE, strict=True):
        scatter(placer, room, name)
    stations = _tour(placer.things, (west, east), hall, doors)
    return World(dict(enumerate(placer.things, start=1)), tuple(stations), placer.relations)


def _build(placer: Placer, west: Room, hall: Room, doors: list[Doorway], apart: float) -> None:
    """The shell of the western room, the same again, that of the hall, and the frames of the doors."""
    rng = placer.rng
    look, floor, wood = finish(warm_floor(rng), rng), warm_floor(rng), lacquer(rng)
    own = shell(west, (doors[0],), look)
    into_rooms = tuple(Doorway("south", door.start, door.end) for door in doors)
    hall_floor, *rest = shell(hall, into_rooms, finish(floor, rng))
    frames, thresholds = zip(*(door_frame(d, west.high[1], hall.low[1], wood, floor) for d in doors), strict=True)
    hall_floor = Thing("floor", (*hall_floor.solids, *thresholds))
    for thing in (*own, *(thing.placed(apart, 0) for thing in own), hall_floor, *rest, *frames):
        placer.add(thing)
    for frame in frames:
        placer.arrangement.stands(frame)
    for door in doors:
        placer.keep_free((door.start, west.high[1] - 0.7, 0), (door.end, hall.low[1] + 0.7, DOOR_HEIGHT_M))


def _repeat(placer: Placer, first: int, apart: float) -> None:
    """All things from `first` on once more in the other room, with their relations."""
    things, relations = placer.things[first:], placer.relations
    moved = len(things)
    for thing in things:
        dyed = _dyed(thing, placer.rng) if placer.rng.uniform() < _DYED else thing
        placer.add(dyed.placed(apart, 0))
    for one, relation, other in relations:
        if one > first:
            shift = moved if other > first else _N_SHELL
            placer.arrangement.relations.append((one + moved, relation, other + shift))


def _dyed(thing: Thing, rng: np.random.Generator) -> Thing:
    dye = rng.uniform(*_DYE, 3)
    return Thing(thing.class_name, tuple(_solid_dyed(solid, dye) for solid in thing.solids))


def _solid_dyed(solid: Solid, dye: np.ndarray) -> Solid:
    def changed(colour: Colour) -> Colour:
        red, green, blue = (np.array(colour) * dye).tolist()
        return red, green, blue

    paint = solid.material
    return replace(solid, material=replace(paint, dark=changed(paint.dark), light=changed(paint.light)))


def _tour(things: list[Thing], both: tuple[Room, Room], hall: Room, doors: list[Doorway]) -> list[Station]:
    """From the western end of the hall into each room, round it, and back."""
    start, ahead = (1.2, hall.center[1]), (3.5, hall.center[1])
    path = CameraPath(FreeSpace(EmptyCells.among(things), hall.center), start)
    path.look(ahead)
    for room, door in zip(both, doors, strict=True):
        path.go(((door.start + door.end) / 2, room.high[1] - 0.5))
        path.round(room.low, room.high, reach=0.35)
    path.go(start)
    path.look(ahead)
    return path.stations
