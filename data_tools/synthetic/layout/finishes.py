"""Paints and floors of rooms."""

from __future__ import annotations

import numpy as np

from data_tools.synthetic.layout.building import Finish
from data_tools.synthetic.shapes.materials import around
from data_tools.synthetic.shapes.solids import Material
from data_tools.synthetic.shapes.thing import tinted

_PALE = ((232, 222, 200), (205, 218, 222), (222, 206, 206), (212, 222, 200), (226, 226, 230))
_FLOORS = (("planks", (200, 155, 110)), ("planks", (165, 120, 85)), ("carpet", (150, 150, 165)))


def warm_floor(rng: np.random.Generator) -> Material:
    """Boards or carpet."""
    texture, colour = _FLOORS[int(rng.integers(len(_FLOORS)))]
    return tinted(texture, around(rng, (colour,)), 0.5, 2.2)


def tiled_floor(rng: np.random.Generator) -> Material:
    """Tiles of kitchens and bathrooms."""
    return tinted("tiles", around(rng, ((215, 212, 205), (175, 185, 190), (120, 125, 130))), 0.4, 1.6)


def concrete_floor(rng: np.random.Generator) -> Material:
    """The grey of halls for work."""
    return tinted("terrazzo", around(rng, ((165, 165, 160), (140, 145, 150))), 0.4, 2.6)


def finish(floor: Material, rng: np.random.Generator) -> Finish:
    """Three walls of one paint, mostly plain, and one of another."""
    paint = tinted("plaster" if rng.uniform() < 0.5 else "smooth", around(rng, _PALE), 0.3, 2.6)
    feature = tinted("bricks" if rng.uniform() < 0.3 else "plaster", around(rng, _PALE, 30), 0.4, 2.2)
    ceiling = tinted("plaster", around(rng, ((240, 240, 238),)), 0.2, 3.3)
    walls = [paint] * 4
    walls[int(rng.integers(4))] = feature
    return Finish(floor, ceiling, (walls[0], walls[1], walls[2], walls[3]))
