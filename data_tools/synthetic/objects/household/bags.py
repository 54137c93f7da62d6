"""Bags and cases: one maker per class, each varies size, proportions and colours."""

from __future__ import annotations

import numpy as np

from data_tools.synthetic.shapes import materials as m
from data_tools.synthetic.shapes.primitives import bars, block, cylinder, soft_box, tapered, tube
from data_tools.synthetic.shapes.solids import Material, Point, Solid
from data_tools.synthetic.shapes.thing import Thing, tinted
from data_tools.synthetic.shapes.transforms import turned


def backpack(rng: np.random.Generator) -> Thing:
    """A standing rucksack: body, lid, front and side pockets, a loop and two straps behind."""
    width, depth, height = rng.uniform(0.28, 0.36), rng.uniform(0.15, 0.2), rng.uniform(0.4, 0.52)
    cloth, trim = m.fabric(rng), m.dark_plastic(rng)
    half = depth / 2
    solids = [soft_box((-width / 2, -half, 0), (width / 2, half, height), (0.05, 0.05, 0.07), cloth)]
    pocket_high = height * rng.uniform(0.45, 0.55)
    solids.append(
        soft_box(
            (-width * 0.36, half - 0.03, 0.02), (width * 0.36, half + 0.05, pocket_high), (0.03, 0.03, 0.03), cloth
        )
    )
    solids.append(block(0, half + 0.006, pocket_high + 0.07, (width * 0.55, 0.012, 0.012), trim))
    solids += [
        soft_box((min(a, b), -0.05, 0.02), (max(a, b), 0.05, height * 0.35), (0.02, 0.03, 0.02), trim)
        for a, b in ((-width / 2 - 0.03, -width / 2 + 0.03), (width / 2 - 0.03, width / 2 + 0.03))
    ]
    for side in (-1, 1):
        x = side * width * 0.24
        points = [
            (x, -half + 0.02, height - 0.06),
            (x, -half - 0.045, height * 0.65),
            (x, -half - 0.035, height * 0.3),
            (x, -half + 0.02, 0.07),
        ]
        solids += bars(points, 0.05, 0.014, trim)
    loop = [
        (-0.04, -half + 0.05, height - 0.02),
        (-0.025, -half + 0.03, height + 0.035),
        (0.025, -half + 0.03, height + 0.035),
        (0.04, -half + 0.05, height - 0.02),
    ]
    return Thing("backpack", (*solids, *bars(loop, 0.02, 0.008, trim)))


def _open_sack(size: Point, spread: float, wall: float, material: Material) -> list[Solid]:
    """Four thin walls that lean outwards by `spread` on a bottom."""
    x, y, height = size[0] / 2, size[1] / 2, size[2]
    solids = [block(0, 0, 0, (2 * x - 2 * wall, 2 * y - 2 * wall, wall), material)]
    for side in (-1, 1):
        low, high = sorted((side * x, side * (x - wall)))
        out = side * spread
        solids.append(
            tapered((low, -y, high, y), (low + out, -y - spread, high + out, y + spread), 0, height, material)
        )
        low, high = sorted((side * y, side * (y - wall)))
        flat = (-x + wall, low, x - wall, high)
        solids.append(tapered(flat, (flat[0] - spread, low + out, flat[2] + spread, high + out), 0, height, material))
    return solids


def _carrier(name: str, rng: np.random.Generator, size: Point, material: Material, strap: Material) -> Thing:
    """An open bag with a handle arched over each long side."""
    spread = rng.uniform(0.0, 0.015)
    solids = _open_sack(size, spread, 0.005, material)
    reach, height = size[0] * 0.2, size[2]
    for side in (-1, 1):
        y = side * (size[1] / 2 + spread + 0.004)
        arch = [
            (-reach, y, height - 0.05),
            (-reach * 0.8, y, height + 0.1),
            (reach * 0.8, y, height + 0.1),
            (reach, y, height - 0.05),
        ]
        solids += bars(arch, 0.02, 0.006, strap)
    return Thing(name, tuple(solids))


def bag(rng: np.random.Generator) -> Thing:
    """A cloth shopping bag."""
    size = rng.uniform(0.32, 0.42), rng.uniform(0.12, 0.18), rng.uniform(0.3, 0.4)
    cloth = m.patterned(rng) if rng.uniform() < 0.5 else m.fabric(rng)
    return _carrier("bag", rng, size, cloth, m.fabric(rng))


def paper_bag(rng: np.random.Generator) -> Thing:
    """A brown paper carrier bag."""
    size = rng.uniform(0.24, 0.32), rng.uniform(0.12, 0.16), rng.uniform(0.3, 0.38)
    return _carrier("paper bag", rng, size, m.cardboard(rng), m.cardboard(rng))


def purse(rng: np.random.Generator) -> Thing:
    """A handbag: a tapering leather body, a flap with a clasp, a short handle."""
    width, depth, height = rng.uniform(0.24, 0.32), rng.uniform(0.09, 0.13), rng.uniform(0.18, 0.24)
    hide, clasp = m.leather(rng), tinted("smooth", (205.0, 170.0, 90.0), 0.3)
    x, y = width / 2, depth / 2
    body = tapered((-x, -y, x, y), (-x * 0.8, -y * 0.4, x * 0.8, y * 0.4), 0, height, hide)
    flap = tapered(
        (-x * 0.86, y * 0.1, x * 0.86, y * 0.92),
        (-x * 0.78, -y * 0.3, x * 0.78, y * 0.5),
        height * 0.45,
        height + 0.006,
        hide,
    )
    arch = [
        (-x * 0.6, 0.0, height - 0.01),
        (-x * 0.45, 0.0, height + 0.11),
        (x * 0.45, 0.0, height + 0.11),
        (x * 0.6, 0.0, height - 0.01),
    ]
    handle = bars(arch, 0.018, 0.012, hide)
    return Thing("purse", (body, flap, *handle, block(0, y * 0.9, height * 0.47, (0.03, 0.02, 0.03), clasp)))


def suitcase(rng: np.random.Generator) -> Thing:
    """An upright trolley case: ribbed shell, four wheels and a pulled-out handle."""
    width, depth, height = rng.uniform(0.38, 0.5), rng.uniform(0.22, 0.3), rng.uniform(0.5, 0.7)
    shell, dark = m.plastic(rng), m.dark_plastic(rng)
    low, high = (-width / 2, -depth / 2, 0.05), (width / 2, depth / 2, 0.05 + height)
    solids = [soft_box(low, high, (0.05, 0.04, 0.05), shell)]
    solids += [
        block(x, depth / 2 + 0.003, 0.12, (0.025, 0.012, height - 0.14), shell)
        for x in np.linspace(-0.3, 0.3, 5) * width
    ]
    solids += [
        turned(
            cylinder(0.027, -0.012, 0.012, dark, 8), "y", 90, (s * (width / 2 - 0.06), t * (depth / 2 - 0.06), 0.027)
        )
        for s in (-1, 1)
        for t in (-1, 1)
    ]
    top = 0.05 + height + rng.uniform(0.15, 0.4)
    solids += [
        tube((s * 0.09, -depth / 2 + 0.05, height), (s * 0.09, -depth / 2 + 0.05, top), 0.009, dark) for s in (-1, 1)
    ]
    return Thing("suitcase", (*solids, block(0, -depth / 2 + 0.05, top - 0.01, (0.22, 0.03, 0.03), dark)))
