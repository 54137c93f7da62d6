"""A synthetic world: its objects, and the stations of the camera."""

from __future__ import annotations

from dataclasses import dataclass

from data_tools.synthetic.camera.walk import Station
from data_tools.synthetic.shapes.thing import Thing


@dataclass(frozen=True, slots=True)
class World:
    """Things by instance id >= 1, z up in metres, and the stations of the camera's walk."""

    things: dict[int, Thing]
    stations: tuple[Station, ...]
