"""A synthetic world: its objects, and the stations of the camera."""

from __future__ import annotations

from dataclasses import dataclass

from data_tools.synthetic.camera.walk import Station
from data_tools.synthetic.layout.arrangement import Triple
from data_tools.synthetic.shapes.thing import Thing


@dataclass(frozen=True, slots=True)
class World:
    """Things by instance id >= 1, z up in metres, the stations of the camera's walk, and how things were placed: (id,
    relation, id), such as a cup that is *on* a table."""

    things: dict[int, Thing]
    stations: tuple[Station, ...]
    relations: tuple[Triple, ...] = ()
