"""Paints and floors of rooms."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from typing import Literal

import numpy as np

from data_tools.synthetic.layout.building import Finish
from data_tools.synthetic.shapes.materials import around
from data_tools.synthetic.shapes.solids import Material
from data_tools.synthetic.shapes.thing import Thing, tinted

# "painted": a roller's grain and slow unevenness, which is faint; "textured": what has corners to be found again;
# "bare": one even colour.
Walls = Literal["painted", "textured", "bare"]

_WHITES = ((240, 238, 232), (236, 232, 222), (232, 233, 232), (242, 241, 238))
_TINTS = ((208, 214, 208), (200, 209, 216), (224, 212, 196), (214, 208, 202), (190, 198, 196))
# Rough plaster, bricks, panels of wood, printed paper: contrast, and metres of a tile.
_COVERINGS = (("plaster", 0.4, 1.8), ("bricks", 0.5, 2.0), ("planks", 0.45, 2.2), ("shapes", 0.3, 1.4))
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


def with_walls(things: Mapping[int, Thing], walls: Walls, seed: int) -> dict[int, Thing]:
    """The things of a world with walls and ceilings of another finish, in the colours that they have.

    Args:
        things: instance id -> Thing.
        walls: the finish; "painted" is that which they are made with.
        seed: of what covers which wall, where they are textured.
    """
    if walls == "painted":
        return dict(things)
    rng = np.random.default_rng([seed, 91])
    return {number: _refinished(thing, walls, rng) for number, thing in things.items()}


def _refinished(thing: Thing, walls: Walls, rng: np.random.Generator) -> Thing:
    if thing.class_name not in ("wall", "ceiling"):
        return thing
    texture, contrast, tile_m = _COVERINGS[int(rng.integers(len(_COVERINGS))) if thing.class_name == "wall" else 0]
    if walls == "bare":
        texture, contrast = "smooth", 0.0
    return Thing(
        thing.class_name,
        tuple(replace(s, material=tinted(texture, s.material.light, contrast, tile_m)) for s in thing.solids),
    )
