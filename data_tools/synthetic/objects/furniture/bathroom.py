"""Bathroom and laundry: one maker per class, each varies size, proportions and colours."""

from __future__ import annotations

import numpy as np

from data_tools.synthetic.shapes import materials as m
from data_tools.synthetic.shapes.primitives import block, cylinder, disc, rounded, tapered, tube
from data_tools.synthetic.shapes.solids import Material, Point, Solid, lathe
from data_tools.synthetic.shapes.thing import Thing, tinted
from data_tools.synthetic.shapes.transforms import shifted, stretched, turned


def _tap(at: Point, height: float, reach: float, chrome: Material) -> list[Solid]:
    """A tap standing at a point, its spout towards +y, with a lever."""
    x, y, z = at
    solids = [tube(at, (x, y, z + height), 0.016, chrome, 8)]
    solids.append(tube((x, y - 0.01, z + height - 0.015), (x, y + reach, z + height - 0.03), 0.011, chrome))
    solids.append(block(x, y + reach - 0.01, z + height - 0.06, (0.018, 0.018, 0.03), chrome))
    return [*solids, block(x, y + 0.01, z + height, (0.018, 0.06, 0.012), chrome)]


def sink(rng: np.random.Generator) -> Thing:
    """A washbasin on a pedestal, with a tap behind its hollow."""
    height, stretch = rng.uniform(0.8, 0.88), rng.uniform(1.15, 1.4)
    white, chrome = m.ceramic(rng), tinted("smooth", (205.0, 208.0, 212.0), 0.3)
    outside = [(0, height - 0.22), (0.12, height - 0.22), (0.215, height - 0.1), (0.23, height)]
    hollow = [(0.19, height), (0.1, height - 0.11), (0, height - 0.12)]
    basin = stretched(lathe([*outside, *hollow], white, sides=16), (stretch, 1, 1))
    foot = tapered((-0.085, -0.1, 0.085, 0.05), (-0.065, -0.09, 0.065, 0.04), 0, height - 0.21, white)
    ledge = rounded((-0.2, -0.26, height - 0.12), (0.2, -0.16, height + 0.004), "z", 0.03, white)
    drain = cylinder(0.02, height - 0.121, height - 0.116, chrome, 8)
    return Thing("sink", (foot, basin, ledge, drain, *_tap((0, -0.2, height + 0.003), 0.12, 0.11, chrome)))


def toilet(rng: np.random.Generator) -> Thing:
    """A toilet: a bowl with a seat, a raised lid, a cistern with a button."""
    seat, tank = rng.uniform(0.38, 0.43), rng.uniform(0.33, 0.4)
    white, lid = m.ceramic(rng), m.ceramic(rng) if rng.uniform() < 0.92 else m.wood(rng)
    profile = [
        (0, 0),
        (0.12, 0),
        (0.1, seat * 0.45),
        (0.185, seat - 0.02),
        (0.12, seat - 0.02),
        (0.06, seat * 0.55),
        (0, seat * 0.5),
    ]
    bowl = shifted(stretched(lathe(profile, white, sides=12), (1, 1.3, 1)), 0, 0.1, 0)
    ring = [(0.11, seat - 0.02), (0.19, seat - 0.02), (0.19, seat), (0.11, seat), (0.11, seat - 0.02)]
    rim = shifted(stretched(lathe(ring, lid, sides=12), (1, 1.3, 1)), 0, 0.1, 0)
    cover = turned(stretched(cylinder(0.185, 0, 0.018, lid, 14), (1, 1.2, 1)), "x", 96, (0, -0.145, seat + 0.235))
    base = block(0, -0.19, 0, (0.2, 0.24, seat - 0.03), white)
    box_ = rounded((-0.19, -0.35, seat - 0.03), (0.19, -0.18, seat + tank), "z", 0.02, white)
    top = rounded((-0.2, -0.36, seat + tank), (0.2, -0.172, seat + tank + 0.03), "z", 0.02, white)
    button = shifted(cylinder(0.025, 0, 0.008, m.metal(rng), 6), 0, -0.26, seat + tank + 0.03)
    return Thing("toilet", (bowl, rim, cover, base, box_, top, button))


def bathtub(rng: np.random.Generator) -> Thing:
    """A tub with sloping inner walls, a rim and a tap at one end."""
    long, wide, high = rng.uniform(1.5, 1.75) / 2, rng.uniform(0.7, 0.8) / 2, rng.uniform(0.5, 0.6)
    white, chrome = m.ceramic(rng), tinted("smooth", (205.0, 208.0, 212.0), 0.3)
    x_low, y_low, x_top, y_top = long - 0.22, wide - 0.16, long - 0.08, wide - 0.07
    solids = [block(0, 0, 0, (2 * x_low, 2 * y_low, 0.12), white)]
    ends = [
        ((-long, -wide, -x_low, wide), (-long, -wide, -x_top, wide)),
        ((x_low, -wide, long, wide), (x_top, -wide, long, wide)),
    ]
    flanks = [
        ((-x_low, -wide, x_low, -y_low), (-x_top, -wide, x_top, -y_top)),
        ((-x_low, y_low, x_low, wide), (-x_top, y_top, x_top, wide)),
    ]
    solids += [tapered(bottom, top, 0, high, white) for bottom, top in (*ends, *flanks)]
    bars = [block(s * (long - 0.035), 0, high, (0.09, 2 * wide + 0.02, 0.025), white) for s in (-1, 1)]
    bars += [block(0, s * (wide - 0.025), high, (2 * long - 0.16, 0.07, 0.025), white) for s in (-1, 1)]
    tap = [turned(part, "z", 90, (long - 0.04, 0, 0)) for part in _tap((0, 0, high + 0.025), 0.14, 0.15, chrome)]
    drain = shifted(cylinder(0.025, 0.12, 0.124, chrome, 8), long - 0.35, 0, 0)
    return Thing("bathtub", (*solids, *bars, *tap, drain))


def _front_loader(name: str, rng: np.random.Generator, glass: Material) -> Thing:
    """A white cube with a round door, a drawer or a dial, and a display."""
    width, depth, height = rng.uniform(0.58, 0.62), rng.uniform(0.5, 0.62), rng.uniform(0.83, 0.88)
    skin = tinted("smooth", m.around(rng, ((242, 242, 240), (200, 202, 205)), 4), 0.08)
    ring, dark = m.metal(rng), m.dark_plastic(rng)
    front = depth / 2
    solids = [block(s * (width / 2 - 0.05), 0, 0, (0.05, depth - 0.08, 0.02), dark) for s in (-1, 1)]
    solids.append(block(0, 0, 0.02, (width, depth, height - 0.05), skin))
    solids.append(block(0, 0, height - 0.03, (width + 0.01, depth + 0.02, 0.03), skin))
    solids.append(disc(0.2, 0.025, (0, front, 0.42), ring, 18))
    solids.append(disc(0.155, 0.02, (0, front + 0.025, 0.42), glass, 18))
    solids.append(block(0.175, front + 0.03, 0.4, (0.03, 0.02, 0.06), dark))
    solids.append(block(0, front + 0.003, height - 0.155, (width - 0.01, 0.006, 0.012), dark))
    solids.append(disc(0.035, 0.03, (0.02, front, height - 0.085), ring, 10))
    solids.append(block(0.19, front + 0.004, height - 0.11, (0.13, 0.008, 0.05), m.display(rng)))
    return Thing(name, (*solids, block(-width / 2 + 0.11, front + 0.007, height - 0.125, (0.17, 0.014, 0.08), skin)))


def washing_machine(rng: np.random.Generator) -> Thing:
    """A front loader with a dark porthole."""
    return _front_loader("washing machine", rng, m.black_glass())


def clothes_dryer(rng: np.random.Generator) -> Thing:
    """A dryer with a closed pale door."""
    return _front_loader("clothes dryer", rng, m.ceramic(rng))


def shower(rng: np.random.Generator) -> Thing:
    """A corner shower: a tray, glass panes on posts at two sides, a rod with a shower head."""
    side, height = rng.uniform(0.8, 0.95), rng.uniform(1.9, 2.05)
    white, chrome = m.ceramic(rng), m.metal(rng)
    glass = tinted("clouds", (205.0, 225.0, 228.0), 0.25)
    half = side / 2
    rims = [block(s * (half - 0.03), 0, 0.06, (0.06, side, 0.06), white) for s in (-1, 1)]
    rims += [block(0, s * (half - 0.03), 0.06, (side - 0.12, 0.06, 0.06), white) for s in (-1, 1)]
    posts = [
        block(x, y, 0.12, (0.03, 0.03, height - 0.12), chrome)
        for x, y in ((half - 0.03, half - 0.03), (half - 0.03, -half + 0.03), (-half + 0.03, half - 0.03))
    ]
    panes = [block(half - 0.03, 0, 0.12, (0.012, side - 0.09, height - 0.14), glass)]
    panes.append(block(half * 0.45, half - 0.03, 0.12, (half * 0.9, 0.012, height - 0.14), glass))
    panes.append(block(0, half - 0.03, height - 0.02, (side - 0.09, 0.02, 0.02), chrome))
    x, y = -half + 0.12, -half + 0.06
    rod = [
        tube((x, y, 0.06), (x, y, height - 0.05), 0.012, chrome),
        tube((x, y, height - 0.06), (x + 0.02, y + 0.2, height - 0.03), 0.01, chrome),
    ]
    head = shifted(cylinder(0.08, -0.02, 0.005, chrome, 12), x + 0.02, y + 0.2, height - 0.035)
    valve = block(x, y - 0.01, 0.95, (0.16, 0.06, 0.05), chrome)
    return Thing("shower", (block(0, 0, 0, (side, side, 0.06), white), *rims, *posts, *panes, *rod, head, valve))


def toilet_paper(rng: np.random.Generator) -> Thing:
    """A roll standing on its end, with its cardboard core."""
    return _roll("toilet paper", rng.uniform(0.05, 0.06), rng.uniform(0.09, 0.11), 0.02, rng)


def paper_towel_roll(rng: np.random.Generator) -> Thing:
    """A tall roll standing on its end."""
    return _roll("paper towel roll", rng.uniform(0.055, 0.07), rng.uniform(0.22, 0.27), 0.02, rng)


def _roll(name: str, radius: float, height: float, core: float, rng: np.random.Generator) -> Thing:
    paper = tinted("smooth", m.hue(rng, (0.0, 0.06), (0.93, 0.98)), 0.12, 0.3)
    ring = [(core, 0), (radius, 0), (radius, height), (core, height), (core, 0)]
    return Thing(name, (lathe(ring, paper, sides=14),))
