"""Paints and floors of rooms."""

from __future__ import annotations

import numpy as np

from data_tools.synthetic.layout.building import Finish
from data_tools.synthetic.shapes.materials import around
from data_tools.synthetic.shapes.solids import Material
from data_tools.synthetic.shapes.thing import tinted

_WHITES = ((240, 238, 232), (236, 232, 222), (232, 233, 232), (242, 241, 238))
_TINTS = ((208, 214, 208), (200, 209, 216), (224, 212, 196), (214, 208, 202), (190, 198, 196))
_FLOORS = (("planks", (205, 165, 120)), ("planks", (176, 132, 95)), ("cloth", (176, 168, 156)))


def warm_floor(rng: np.random.Generator) -> Material:
    """Boards or carpet."""
    texture, colour = _FLOORS[int(rng.integers(len(_FLOORS)))]
    return tinted(texture, around(rng, (colour,)), 0.36, 2.2 if texture == "planks" else 0.7)


def tiled_floor(rng: np.random.Generator) -> Material:
    """Tiles of kitchens and bathrooms."""
    return tinted("tiles", around(rng, ((226, 222, 214), (196, 200, 202), (150, 152, 154)), 6), 0.3, 2.4)


def concrete_floor(rng: np.random.Generator) -> Material:
    """The grey of halls for work."""
    return tinted("paint", around(rng, ((172, 170, 164), (156, 157, 158)), 5), 0.14, 3.2)


def finish(floor: Material, rng: np.random.Generator) -> Finish:
    """Three walls of one paint, mostly plain, and one of another."""
    paint = tinted("paint", around(rng, _WHITES, 4), 0.09, 1.1)
    feature = tinted("paint", around(rng, _TINTS, 6), 0.1, 1.1)
    ceiling = tinted("paint", around(rng, ((246, 246, 244),), 3), 0.07, 1.4)
    walls = [paint] * 4
    walls[int(rng.integers(4))] = feature
    return Finish(floor, ceiling, (walls[0], walls[1], walls[2], walls[3]))
