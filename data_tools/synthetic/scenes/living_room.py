"""The demo room: a 5 x 4 x 2.6 m living room with a table, six look-alike chairs and what stands around."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from data_tools.synthetic.layout.arrangement import Arrangement, Triple
from data_tools.synthetic.layout.building import flat
from data_tools.synthetic.objects.furniture import simple_furniture as f
from data_tools.synthetic.shapes.solids import Material
from data_tools.synthetic.shapes.thing import Thing, tinted

LENGTH_M, WIDTH_M, HEIGHT_M = 5.0, 4.0, 2.6
_X, _Y = LENGTH_M / 2, WIDTH_M / 2
_TABLE_M = 0.75
_CABINET_M = 0.8
_MOVABLE_CHAIR = 1
_N_SHELL = 6


@dataclass(frozen=True, slots=True)
class Layout:
    """What stands where, world z up in metres: instance id -> thing; if one is moved, its other place; and how things
    were placed, as (id, relation, id)."""

    things: dict[int, Thing]
    movable: int
    elsewhere: Thing
    relations: tuple[Triple, ...]


def living_room(seed: int) -> Layout:
    """About 30 things that stand on things; the seed varies colours and nudges the furniture."""
    rng = np.random.default_rng([seed, 1])
    chairs, elsewhere = _chairs(rng)
    shell, furniture, small = _shell(rng), _furniture(rng), _small_things(rng)
    things = [*shell, *chairs, *furniture, *small]
    movable = next(number for number, thing in enumerate(things, start=1) if thing is chairs[_MOVABLE_CHAIR])
    return Layout(dict(enumerate(things, start=1)), movable, elsewhere, _relations(things, furniture, small))


def _relations(things: list[Thing], furniture: list[Thing], small: list[Thing]) -> tuple[Triple, ...]:
    """What stands on the floor, hangs on a wall, and stands on furniture or in the shelf."""
    arrangement = Arrangement(things)
    for thing in things[_N_SHELL : -len(small)]:
        (arrangement.hangs if thing.class_name == "picture" else arrangement.stands)(thing)
    table, cabinet, shelf = furniture[0], furniture[3], furniture[4]
    for thing, support in zip(small, (cabinet, shelf, shelf, table, table, table, cabinet), strict=True):
        arrangement.rests(thing, support, enclosed=support is shelf)
    return tuple(arrangement.relations)


def _colour(rng: np.random.Generator, base: tuple[float, float, float]) -> tuple[float, float, float]:
    red, green, blue = np.clip(np.array(base) + rng.uniform(-18, 18, 3), 20, 250)
    return float(red), float(green), float(blue)


def _shell(rng: np.random.Generator) -> list[Thing]:
    """Floor, ceiling and four walls, each an instance of its own."""
    wall = tinted("plaster", _colour(rng, (222, 208, 180)), 0.45, 2.6)
    feature = tinted("bricks", _colour(rng, (205, 130, 105)), 0.6, 2.0)
    floor = tinted("planks", _colour(rng, (205, 160, 115)), 0.65, 2.2)
    ceiling = tinted("plaster", _colour(rng, (238, 238, 236)), 0.3, 3.3)
    x, y, z = LENGTH_M, WIDTH_M, HEIGHT_M
    return [
        Thing("floor", (flat((-_X, -_Y, 0), (x, 0, 0), (0, y, 0), floor),)),
        Thing("ceiling", (flat((-_X, -_Y, z), (0, y, 0), (x, 0, 0), ceiling),)),
        Thing("wall", (flat((_X, -_Y, 0), (-x, 0, 0), (0, 0, z), wall),)),
        Thing("wall", (flat((_X, _Y, 0), (0, -y, 0), (0, 0, z), wall),)),
        Thing("wall", (flat((-_X, _Y, 0), (x, 0, 0), (0, 0, z), wall),)),
        Thing("wall", (flat((-_X, -_Y, 0), (0, y, 0), (0, 0, z), feature),)),
    ]


def _chairs(rng: np.random.Generator) -> tuple[list[Thing], Thing]:
    """Six equal chairs round the table, and where the movable one can also stand, a metre away."""
    chair = f.chair(
        tinted("wood", _colour(rng, (120, 80, 50))), tinted("fabric", _colour(rng, (70, 120, 150)), 0.7, 0.8)
    )
    places = [
        (-0.2, -0.75, 0),
        (0.65, -0.75, 0),
        (-0.2, 0.75, 180),
        (0.65, 0.75, 180),
        (-0.9, 0.0, -90),
        (1.38, 0.0, 90),
    ]
    nudges = rng.uniform(-1, 1, (len(places), 3)) * (0.03, 0.03, 7)
    chairs = [
        chair.placed(x + dx, y + dy, 0.0, yaw + turn)
        for (x, y, yaw), (dx, dy, turn) in zip(places, nudges, strict=True)
    ]
    return chairs, chair.placed(1.62, -0.98, 0.0, 40.0)


def _furniture(rng: np.random.Generator) -> list[Thing]:
    """What stands on the floor or hangs on a wall."""
    oak = tinted("wood", _colour(rng, (200, 150, 95)))
    white = tinted("terrazzo", _colour(rng, (230, 228, 222)), 0.3)
    sofa_cloth = tinted("fabric", _colour(rng, (150, 70, 70)), 0.65, 1.2)
    armchair_cloth = tinted("fabric", _colour(rng, (95, 140, 85)), 0.65, 1.2)
    metal = tinted("wood", _colour(rng, (90, 90, 95)), 0.5)
    lampshade = tinted("plaster", _colour(rng, (245, 225, 170)), 0.35, 0.8)
    leaves = Material("terrazzo", (25, 60, 20), _colour(rng, (120, 190, 80)), 0.9)
    art = Material("shapes", _colour(rng, (40, 50, 120)), _colour(rng, (245, 200, 80)), 0.9)
    art_too = Material("shapes", _colour(rng, (120, 40, 60)), _colour(rng, (225, 235, 220)), 0.9)
    gap = 0.005
    return [
        f.table(1.6, 0.85, _TABLE_M, oak, metal).placed(0.23, 0.0),
        f.sofa(1.9, sofa_cloth).placed(-1.05, _Y - 0.4 - gap, yaw_deg=180),
        f.sofa(0.9, armchair_cloth, "armchair").placed(1.05, _Y - 0.445, yaw_deg=175),
        f.cabinet(1.3, 0.45, _CABINET_M, oak, white).placed(-1.3, -_Y + 0.225 + gap),
        f.shelf(1.0, 0.3, 1.8, 5, white).placed(-_X + 0.15 + gap, 0.1, yaw_deg=-90),
        f.floor_lamp(metal, lampshade).placed(2.15, 1.65),
        f.plant(tinted("bricks", _colour(rng, (190, 100, 70)), 0.5, 0.5), leaves).placed(2.15, -1.62),
        f.panel("picture", 1.0, 0.65, 0.03, metal, art).placed(-1.0, _Y, 1.25, yaw_deg=180),
        f.panel("picture", 0.6, 0.8, 0.03, metal, art_too).placed(1.0, -_Y, 1.2),
        f.panel("door", 0.9, 2.05, 0.04, white, oak).placed(_X, 0.3, 0.0, yaw_deg=90),
        f.carton((0.5, 0.36, 0.34), tinted("shapes", _colour(rng, (190, 150, 105)), 0.4)).placed(1.1, -1.6, yaw_deg=8),
        f.bin_(tinted("terrazzo", _colour(rng, (110, 130, 160)), 0.5, 0.6)).placed(0.1, -1.7),
    ]


def _small_things(rng: np.random.Generator) -> list[Thing]:
    """What stands on furniture."""
    screen = Material("screen", (15, 20, 45), (205, 225, 250), 0.7)
    heights = f.shelf_heights(1.8, 5)
    on_shelf = -_X + 0.165
    return [
        f.monitor(tinted("plaster", (60.0, 60.0, 66.0), 0.5), screen).placed(-1.45, -_Y + 0.25, _CABINET_M),
        f.books(0.8, 0.3, rng).placed(on_shelf, 0.1, float(heights[2]), -90),
        f.books(0.7, 0.3, rng).placed(on_shelf, 0.15, float(heights[1]), -90),
        f.mug(tinted("terrazzo", _colour(rng, (210, 60, 50)), 0.6, 0.4)).placed(-0.1, 0.18, _TABLE_M, 30),
        f.bottle(tinted("plaster", _colour(rng, (60, 130, 70)), 0.6, 0.6)).placed(0.3, -0.1, _TABLE_M),
        f.bowl(tinted("terrazzo", _colour(rng, (90, 110, 200)), 0.6, 0.5)).placed(0.68, 0.1, _TABLE_M),
        f.carton((0.26, 0.2, 0.16), tinted("shapes", _colour(rng, (210, 90, 150)), 0.6)).placed(
            -0.95, -_Y + 0.24, _CABINET_M, 12
        ),
    ]
