"""A furnished living room and a walk round it."""

from __future__ import annotations

import numpy as np

from data_tools.synthetic.camera.camera_path import CameraPath
from data_tools.synthetic.layout.building import Room, shell
from data_tools.synthetic.layout.finishes import finish, warm_floor
from data_tools.synthetic.layout.free_space import EmptyCells, FreeSpace
from data_tools.synthetic.layout.furnishing import against
from data_tools.synthetic.layout.placement import Placer
from data_tools.synthetic.scenes.apartment_rooms import living_room
from data_tools.synthetic.scenes.world import World


def single_room(seed: int) -> World:
    """About 45 things, among them six equal chairs round a table; the seed varies sizes, places and colours."""
    rng = np.random.default_rng([seed, 21])
    placer = Placer(rng)
    room = Room((0, 0), (float(rng.uniform(5.0, 5.5)), float(rng.uniform(4.1, 4.5))))
    for thing in shell(room, (), finish(warm_floor(rng), rng)):
        placer.add(thing)
    against(placer, room, "north", 0.5, "door")
    living_room(room, placer)
    path = CameraPath(FreeSpace(EmptyCells.among(placer.things), room.center), (room.center[0], room.high[1] - 0.8))
    path.round(room.low, room.high, reach=0.45, turns=1.0, places=8)
    return World(dict(enumerate(placer.things, start=1)), tuple(path.stations), placer.relations)
