"""Kitchen furniture and appliances: one maker per class, each varies size, proportions and colours."""

from __future__ import annotations

import numpy as np

from data_tools.synthetic.objects.furniture.storage_furniture import doors, drawers
from data_tools.synthetic.shapes import materials as m
from data_tools.synthetic.shapes.primitives import (
    ball,
    bars,
    beam,
    block,
    cylinder,
    disc,
    legs,
    rounded,
    soft_box,
    tapered,
    tube,
)
from data_tools.synthetic.shapes.solids import Material, Solid, lathe
from data_tools.synthetic.shapes.thing import Thing, tinted
from data_tools.synthetic.shapes.transforms import shifted, turned


def _steel_or_white(rng: np.random.Generator) -> Material:
    return tinted("smooth", m.around(rng, ((190, 192, 195), (240, 240, 238), (90, 92, 96)), 5), 0.12)


def kitchen_cabinet(rng: np.random.Generator) -> Thing:
    """A base unit: recessed plinth, a drawer over each door, a worktop."""
    count = int(rng.integers(1, 4))
    width, depth, height = count * rng.uniform(0.45, 0.6), rng.uniform(0.56, 0.62), rng.uniform(0.86, 0.92)
    body, top, grip = m.wood_or_lacquer(rng), m.stone(rng), m.metal(rng)
    share, front = width / count, depth / 2 - 0.04
    solids = [block(0, -0.04, 0, (width - 0.02, depth - 0.12, 0.1), m.dark_plastic(rng))]
    solids.append(block(0, -0.02, 0.1, (width, depth - 0.04, height - 0.14), body))
    solids.append(block(0, 0, height - 0.04, (width, depth, 0.04), top))
    for i in range(count):
        x = (i + 0.5) * share - width / 2
        solids += drawers(x, front, height - 0.2, height - 0.05, share, 1, body, grip)
    return Thing("kitchen cabinet", (*solids, *doors(front, 0.11, height - 0.2, width, count, body, grip)))


def refrigerator(rng: np.random.Generator) -> Thing:
    """A tall refrigerator: freezer door over or under the larger one, bar handles."""
    width, depth, height = rng.uniform(0.58, 0.8), rng.uniform(0.6, 0.7), rng.uniform(1.6, 1.9)
    return _cold("refrigerator", rng, width, depth, height, rng.choice([0.35, 0.68]))


def mini_fridge(rng: np.random.Generator) -> Thing:
    """A refrigerator of the height of a desk, with one door."""
    return _cold("mini fridge", rng, rng.uniform(0.46, 0.55), rng.uniform(0.46, 0.55), rng.uniform(0.6, 0.85), 1.0)


def _cold(name: str, rng: np.random.Generator, width: float, depth: float, height: float, split: float) -> Thing:
    skin = tinted("smooth", m.around(rng, ((190, 192, 195), (236, 236, 234), (158, 160, 164)), 5), 0.12)
    grip, dark = m.metal(rng), m.dark_plastic(rng)
    solids = [block(0, -0.01, 0, (width - 0.06, depth - 0.06, 0.05), dark)]
    solids.append(block(0, 0, 0.05, (width, depth, height - 0.05), skin))
    cut = 0.05 + split * (height - 0.05)
    side = float(rng.choice([-1, 1])) * (width / 2 - 0.05)
    parts = ((0.055, cut - 0.006), (cut + 0.006, height - 0.005)) if split < 1 else ((0.055, height - 0.005),)
    for low, high in parts:
        solids.append(block(0, depth / 2 + 0.005, low, (width - 0.02, 0.01, high - low), dark))
        solids.append(
            rounded((-width / 2, depth / 2 + 0.01, low), (width / 2, depth / 2 + 0.06, high), "z", 0.012, skin)
        )
        tall = min(0.5, (high - low) * 0.6)
        start = high - tall - 0.06 if low < 0.1 and split < 1 else low + 0.06
        bar = depth / 2 + 0.1
        solids.append(tube((side, bar, start), (side, bar, start + tall), 0.012, grip))
        for z in (start + 0.03, start + tall - 0.03):
            solids.append(block(side, depth / 2 + 0.075, z - 0.01, (0.016, 0.05, 0.02), grip))
    return Thing(name, tuple(solids))


def stove(rng: np.random.Generator) -> Thing:
    """A cooker: four plates on top, a row of knobs, an oven door with a window and a bar."""
    width, depth, height = rng.uniform(0.5, 0.76), rng.uniform(0.58, 0.65), rng.uniform(0.85, 0.92)
    skin, dark, grip = _steel_or_white(rng), m.black_glass(), m.metal(rng)
    front = depth / 2
    solids = [block(0, -0.02, 0, (width - 0.04, depth - 0.08, 0.06), m.dark_plastic(rng))]
    solids.append(block(0, 0, 0.06, (width, depth, height - 0.08), skin))
    solids.append(block(0, 0, height - 0.02, (width - 0.01, depth - 0.01, 0.02), dark))
    solids.append(block(0, -front + 0.02, height, (width, 0.03, rng.uniform(0.06, 0.14)), skin))
    for sx, sy, radius in ((-1, -1, 0.08), (1, -1, 0.1), (-1, 1, 0.1), (1, 1, 0.08)):
        plate = cylinder(radius, height, height + 0.012, grip, 10)
        solids.append(shifted(plate, sx * width * 0.24, sy * 0.13 + 0.02, 0))
    solids += [disc(0.022, 0.03, (x, front, height - 0.08), dark, 6) for x in np.linspace(-0.35, 0.35, 5) * width]
    return Thing("stove", (*solids, *_oven_door(width - 0.03, front, 0.22, height - 0.14, skin, grip)))


def _oven_door(width: float, front: float, low: float, high: float, skin: Material, grip: Material) -> list[Solid]:
    """A door with a dark window and a bar across its top."""
    pane = block(0, front + 0.026, low + 0.06, (width - 0.14, 0.008, high - low - 0.17), m.black_glass())
    bar = tube((-width * 0.4, front + 0.06, high - 0.05), (width * 0.4, front + 0.06, high - 0.05), 0.011, grip)
    posts = [block(s * width * 0.36, front + 0.035, high - 0.06, (0.016, 0.04, 0.02), grip) for s in (-1, 1)]
    return [block(0, front + 0.011, low, (width, 0.022, high - low), skin), pane, bar, *posts]


def oven(rng: np.random.Generator) -> Thing:
    """A built-in oven: a control strip with two knobs and a display over its door."""
    width, depth, height = rng.uniform(0.56, 0.6), rng.uniform(0.5, 0.56), rng.uniform(0.56, 0.6)
    skin, grip = _steel_or_white(rng), m.metal(rng)
    front = depth / 2
    solids = [
        block(0, 0, 0, (width, depth, height), skin),
        *_oven_door(width - 0.01, front, 0.02, height - 0.12, skin, grip),
    ]
    solids += [disc(0.022, 0.028, (s * width * 0.36, front, height - 0.06), grip, 10) for s in (-1, 1)]
    screen = tinted("screen", (120.0, 230.0, 200.0), 0.9, 0.3)
    return Thing("oven", (*solids, block(0, front + 0.003, height - 0.085, (width * 0.3, 0.006, 0.05), screen)))


def microwave(rng: np.random.Generator) -> Thing:
    """A microwave oven: a window and handle on one side, keys and a display on the other."""
    width, depth, height = rng.uniform(0.44, 0.54), rng.uniform(0.32, 0.4), rng.uniform(0.26, 0.31)
    skin, dark, steel = _steel_or_white(rng), m.black_glass(), tinted("smooth", (206.0, 208.0, 210.0), 0.2)
    front, panel = depth / 2, width * 0.26
    solids = [
        block(0, 0, 0.012, (width, depth, height - 0.012), skin),
        *legs(width - 0.04, depth - 0.04, 0.012, 0.03, dark),
    ]
    door = width - panel - 0.006
    solids.append(block(panel / 2, front + 0.008, 0.016, (door, 0.016, height - 0.02), skin))
    solids.append(block(panel / 2, front + 0.018, 0.055, (door - 0.1, 0.004, height - 0.1), dark))
    x = -width / 2 + panel / 2
    solids.append(block(x, front + 0.006, 0.016, (panel - 0.004, 0.012, height - 0.02), dark))
    solids.append(block(x, front + 0.014, height - 0.06, (panel - 0.04, 0.004, 0.03), m.display(rng)))
    rows = np.linspace(0.05, height - 0.1, 4)
    solids += [
        block(x + dx, front + 0.014, float(z), (0.016, 0.004, 0.012), steel) for z in rows for dx in (-0.03, 0, 0.03)
    ]
    handle = -width / 2 + panel + 0.026
    solids.append(block(handle, front + 0.04, 0.05, (0.016, 0.012, height - 0.09), steel))
    solids += [block(handle, front + 0.025, z, (0.014, 0.018, 0.02), steel) for z in (0.06, height - 0.07)]
    return Thing("microwave", tuple(solids))


def dishwasher(rng: np.random.Generator) -> Thing:
    """A dishwasher: a plinth, one flat door, a strip of keys and a recessed grip."""
    width, depth, height = rng.uniform(0.45, 0.6), rng.uniform(0.55, 0.6), rng.uniform(0.82, 0.87)
    skin, dark = _steel_or_white(rng), m.dark_plastic(rng)
    front = depth / 2
    solids = [
        block(0, -0.02, 0, (width - 0.02, depth - 0.06, 0.09), dark),
        block(0, 0, 0.09, (width, depth, height - 0.09), skin),
    ]
    solids.append(block(0, front + 0.01, 0.1, (width - 0.01, 0.02, height - 0.24), skin))
    solids.append(block(0, front + 0.01, height - 0.13, (width - 0.01, 0.02, 0.12), skin))
    solids.append(block(0, front + 0.022, height - 0.115, (width * 0.35, 0.004, 0.035), dark))
    solids += [
        block(x, front + 0.023, height - 0.06, (0.022, 0.006, 0.014), dark) for x in np.linspace(-0.4, 0.4, 7) * width
    ]
    return Thing("dishwasher", tuple(solids))


def range_hood(rng: np.random.Generator) -> Thing:
    """An extractor hood on the wall (back plane y = 0): a chimney over a sloping canopy."""
    width, deep, chimney = rng.uniform(0.6, 0.9), rng.uniform(0.45, 0.52), rng.uniform(0.4, 0.6)
    steel, dark = m.metal(rng), m.dark_plastic(rng)
    half = width / 2
    rim = block(0, deep / 2, 0, (width, deep, 0.05), steel)
    canopy = tapered((-half, 0, half, deep), (-0.13, 0, 0.13, 0.24), 0.05, 0.26, steel)
    keys = [block(x, deep + 0.003, 0.018, (0.02, 0.006, 0.014), dark) for x in (-0.06, -0.02, 0.02, 0.06)]
    return Thing("range hood", (rim, canopy, block(0, 0.12, 0.26, (0.26, 0.24, chimney), steel), *keys))


def toaster(rng: np.random.Generator) -> Thing:
    """A toaster with two slots, bread in them, a lever and a knob."""
    width, depth, height = rng.uniform(0.26, 0.32), rng.uniform(0.15, 0.19), rng.uniform(0.17, 0.2)
    skin, dark = m.metal(rng) if rng.uniform() < 0.5 else m.plastic(rng), m.dark_plastic(rng)
    crust = tinted("terrazzo", (205.0, 150.0, 85.0), 0.4, 0.2)
    body = soft_box((-width / 2, -depth / 2, 0.012), (width / 2, depth / 2, height), (0.02, 0.025, 0.025), skin)
    feet = block(0, 0, 0, (width - 0.06, depth - 0.05, 0.014), dark)
    slots = [block(0, s * 0.035, height, (width - 0.09, 0.028, 0.002), dark) for s in (-1, 1)]
    bread = [block(0, s * 0.035, height, (width - 0.14, 0.014, 0.03), crust) for s in (-1, 1)]
    return Thing(
        "toaster", (body, feet, *slots, *bread, block(width / 2 + 0.01, 0, height * 0.6, (0.03, 0.03, 0.012), dark))
    )


def coffee_maker(rng: np.random.Generator) -> Thing:
    """A filter machine: a foot, a water column behind, a head above and a glass jug between."""
    width, height = rng.uniform(0.17, 0.22), rng.uniform(0.3, 0.37)
    case, glass = m.dark_plastic(rng), tinted("smooth", (95.0, 60.0, 40.0), 0.5, 0.2)
    solids = [rounded((-width / 2, -0.12, 0), (width / 2, 0.12, 0.035), "z", 0.02, case)]
    solids.append(block(0, -0.075, 0.035, (width - 0.01, 0.09, height - 0.135), case))
    solids.append(rounded((-width / 2, -0.12, height - 0.1), (width / 2, 0.11, height), "z", 0.02, case))
    jug = lathe([(0, 0.036), (0.06, 0.036), (0.068, 0.09), (0.045, 0.17), (0, 0.17)], glass, at=(0, 0.045), sides=12)
    handle = [block(0, 0.125, z, (0.015, 0.04, 0.014), case) for z in (0.065, 0.145)]
    return Thing("coffee maker", (*solids, jug, *handle, block(0, 0.14, 0.079, (0.015, 0.014, 0.066), case)))


def coffee_kettle(rng: np.random.Generator) -> Thing:
    """A kettle with a spout and a handle over its lid."""
    radius, height = rng.uniform(0.075, 0.095), rng.uniform(0.16, 0.2)
    skin, dark = m.metal(rng) if rng.uniform() < 0.6 else m.plastic(rng), m.dark_plastic(rng)
    body = lathe([(0, 0), (radius, 0), (radius, height * 0.4), (radius * 0.65, height), (0, height)], skin, sides=12)
    spout = tube((radius * 0.7, 0, height * 0.5), (radius * 1.7, 0, height * 0.95), 0.014, skin)
    arch = [
        (-radius * 0.8, 0.0, height * 0.75),
        (-radius * 0.6, 0.0, height + 0.07),
        (radius * 0.6, 0.0, height + 0.07),
        (radius * 0.8, 0.0, height * 0.75),
    ]
    handle = bars(arch, 0.02, 0.012, dark)
    return Thing(
        "coffee kettle", (body, spout, *handle, ball((0, 0, height + 0.012), (0.014, 0.014, 0.014), dark, 6, 4))
    )


def dish_rack(rng: np.random.Generator) -> Thing:
    """A drainer with a row of plates standing between its bars."""
    width, depth = rng.uniform(0.38, 0.48), rng.uniform(0.28, 0.34)
    wire, china = m.metal(rng), m.glaze(rng)
    corners = [(s * width / 2, t * depth / 2) for s, t in ((-1, -1), (1, -1), (1, 1), (-1, 1))]
    pairs = list(zip(corners, [*corners[1:], corners[0]], strict=True))
    solids = [beam((*a, z), (*b, z), 0.008, 0.008, wire) for z in (0.02, 0.11) for a, b in pairs]
    solids += [block(x, y, 0, (0.009, 0.009, 0.115), wire) for x, y in corners]
    solids += [block(0, y, 0.016, (width, 0.006, 0.006), wire) for y in (-0.05, 0.05)]
    for x in np.linspace(-0.35, 0.25, int(rng.integers(3, 6))) * width:
        solids.append(turned(cylinder(0.105, -0.006, 0.006, china, 12), "y", 78, (float(x), 0, 0.112)))
    return Thing("dish rack", tuple(solids))
