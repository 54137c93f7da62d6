"""Free-standing objects: one maker per class, each varies size, proportions and colours."""

from __future__ import annotations

from itertools import pairwise

import numpy as np

from data_tools.synthetic.shapes import materials as m
from data_tools.synthetic.shapes.primitives import ball, beam, block, cylinder, legs, tapered, tube
from data_tools.synthetic.shapes.solids import lathe
from data_tools.synthetic.shapes.thing import Thing, tinted
from data_tools.synthetic.shapes.transforms import shifted, stretched, turned


def cart(rng: np.random.Generator) -> Thing:
    """A serving trolley: two or three trays on four posts, castors and a push bar."""
    width, depth, height = rng.uniform(0.65, 0.9), rng.uniform(0.4, 0.52), rng.uniform(0.78, 0.92)
    frame, tray = m.metal(rng), m.plastic(rng) if rng.uniform() < 0.5 else m.metal(rng)
    solids = [shifted(s, 0, 0, 0.07) for s in legs(width, depth, height - 0.07, 0.028, frame)]
    for z in np.linspace(0.16, height - 0.08, int(rng.integers(2, 4))):
        solids.append(block(0, 0, float(z), (width - 0.05, depth - 0.05, 0.015), tray))
        solids += [
            block(0, s * (depth / 2 - 0.02), float(z) - 0.002, (width - 0.058, 0.014, 0.05), tray) for s in (-1, 1)
        ]
        solids += [
            block(s * (width / 2 - 0.02), 0, float(z) - 0.002, (0.014, depth - 0.058, 0.05), tray) for s in (-1, 1)
        ]
    wheel = turned(cylinder(0.035, -0.015, 0.015, m.dark_plastic(rng), 8), "y", 90, (0, 0, 0.035))
    solids += [shifted(wheel, s * (width / 2 - 0.02), t * (depth / 2 - 0.02), 0) for s in (-1, 1) for t in (-1, 1)]
    x = width / 2 + 0.06
    solids += [
        tube((width / 2 - 0.014, y, height - 0.03), (x, y, height - 0.01), 0.01, frame)
        for y in (-depth / 2 + 0.014, depth / 2 - 0.014)
    ]
    return Thing("cart", (*solids, tube((x, -depth / 2, height - 0.01), (x, depth / 2, height - 0.01), 0.012, frame)))


def ladder(rng: np.random.Generator) -> Thing:
    """A step ladder, open: treads in front, two struts behind."""
    steps = int(rng.integers(3, 7))
    height, width = 0.25 * steps + 0.1, rng.uniform(0.38, 0.48)
    frame, tread = m.metal(rng), m.dark_plastic(rng)
    front, back = 0.17 * height + 0.1, -0.17 * height - 0.1
    solids = []
    for side in (-1, 1):
        x = side * width / 2
        solids.append(beam((x * 1.1, front, 0.006), (x * 0.8, 0.04, height), 0.025, 0.05, frame))
        solids.append(beam((x * 1.06, back, 0.005), (x * 0.76, -0.04, height - 0.005), 0.022, 0.03, frame))
    for i in range(1, steps + 1):
        z = 0.25 * i
        share = z / height
        solids.append(
            block(0, front + share * (0.04 - front), z - 0.03, (width * (1.1 - 0.3 * share) - 0.01, 0.09, 0.025), tread)
        )
    solids.append(block(0, 0, height - 0.01, (width * 0.84, 0.16, 0.03), tread))
    return Thing(
        "ladder",
        (
            *solids,
            beam(
                (-width * 0.48, back * 0.75, height * 0.25),
                (width * 0.48, back * 0.75, height * 0.25),
                0.02,
                0.02,
                frame,
            ),
        ),
    )


def guitar(rng: np.random.Generator) -> Thing:
    """An acoustic guitar standing upright on its lower end."""
    wood = tinted("wood", m.around(rng, ((215, 150, 80), (170, 80, 45), (235, 195, 130))), 0.35)
    dark = m.dark_plastic(rng)
    k = rng.uniform(0.92, 1.05)
    lower = turned(stretched(cylinder(0.19, -0.05, 0.05, wood, 16), (1, 0.95, 1)), "x", -90, (0, 0, 0.18))
    upper = turned(stretched(cylinder(0.135, -0.0495, 0.0495, wood, 16), (1, 1, 1)), "x", -90, (0, 0, 0.37))
    waist = block(0, 0, 0.2, (0.2, 0.0985, 0.17), wood)
    hole = turned(cylinder(0.048, 0, 0.002, dark, 12), "x", -90, (0, 0.05, 0.31))
    solids = [lower, upper, waist, hole, block(0, 0.054, 0.14, (0.15, 0.008, 0.025), dark)]
    solids += [block(0, 0.056, 0.37, (0.052, 0.014, 0.12), dark), block(0, 0.042, 0.49, (0.05, 0.042, 0.37), dark)]
    solids.append(tapered((-0.03, 0.03, 0.03, 0.055), (-0.042, 0.018, 0.042, 0.043), 0.86, 1.03, wood))
    pegs = [
        block(s * 0.046, 0.035, 0.89 + 0.045 * i, (0.03, 0.012, 0.012), m.metal(rng)) for s in (-1, 1) for i in range(3)
    ]
    return Thing("guitar", tuple(stretched(s, (k, k, k)) for s in (*solids, *pegs)))


def fire_extinguisher(rng: np.random.Generator) -> Thing:
    """A red cylinder with a valve, a lever and a hose."""
    radius, height = rng.uniform(0.07, 0.09), rng.uniform(0.42, 0.55)
    red, dark = tinted("smooth", m.around(rng, ((200, 40, 35),)), 0.2), m.dark_plastic(rng)
    profile = [
        (0, 0),
        (radius, 0),
        (radius, height * 0.78),
        (radius * 0.6, height * 0.88),
        (0.022, height * 0.9),
        (0, height * 0.9),
    ]
    label = lathe(
        [(0, height * 0.3), (radius + 0.001, height * 0.3), (radius + 0.001, height * 0.55), (0, height * 0.55)],
        tinted("notes", (245.0, 240.0, 200.0), 0.8, 0.3),
        sides=12,
    )
    levers = [beam((0, -0.02, z), (0, 0.11, z + 0.03), 0.02, 0.012, dark) for z in (height * 0.93, height * 0.97)]
    hose = [(0.02, 0.0, height * 0.93), (radius + 0.04, 0.0, height * 0.85), (radius + 0.02, 0.0, height * 0.35)]
    pipe = [tube(a, b, 0.01, dark) for a, b in pairwise(hose)]
    return Thing(
        "fire extinguisher",
        (lathe(profile, red, sides=12), label, cylinder(0.018, height * 0.89, height * 0.985, dark, 6), *levers, *pipe),
    )


def column(rng: np.random.Generator) -> Thing:
    """A round column of a room's height with a base and a capital."""
    radius, height = rng.uniform(0.14, 0.22), rng.uniform(2.4, 2.7)
    stone = m.stone(rng)
    ends = [block(0, 0, z, (2.6 * radius, 2.6 * radius, 0.12), stone) for z in (0, height - 0.12)]
    return Thing("column", (*ends, cylinder(radius, 0.12, height - 0.12, stone, 20)))


def coat_rack(rng: np.random.Generator) -> Thing:
    """A coat stand: a pole on three feet, hooks round its top."""
    height, wood = rng.uniform(1.6, 1.85), m.wood(rng)
    solids = [cylinder(0.022, 0.06, height, wood, 8), ball((0, 0, height), (0.035, 0.035, 0.035), wood, 8, 4)]
    for i in range(3):
        c, s = float(np.cos(i * 2.094)), float(np.sin(i * 2.094))
        solids.append(beam((0, 0, 0.2), (0.26 * c, 0.26 * s, 0.0098), 0.03, 0.024, wood))
    for i in range(5):
        c, s = float(np.cos(i * 1.257)), float(np.sin(i * 1.257))
        z = height - 0.1 - 0.12 * (i % 2)
        solids.append(tube((0, 0, z), (0.12 * c, 0.12 * s, z + 0.08), 0.01, wood))
    return Thing("coat rack", tuple(solids))
