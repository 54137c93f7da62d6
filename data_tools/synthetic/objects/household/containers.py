"""Boxes, bins and baskets: one maker per class, each varies size, proportions and colours."""

from __future__ import annotations

import numpy as np

from data_tools.synthetic.shapes import materials as m
from data_tools.synthetic.shapes.primitives import ball, bars, beam, block, cylinder, legs, soft_box, tapered
from data_tools.synthetic.shapes.solids import Colour, Material, Point, Solid, lathe
from data_tools.synthetic.shapes.thing import Thing, tinted
from data_tools.synthetic.shapes.transforms import stretched, turned


def box(rng: np.random.Generator) -> Thing:
    """A cardboard box closed with a tape, sometimes with its flaps open."""
    width, depth, height = rng.uniform(0.25, 0.55), rng.uniform(0.2, 0.4), rng.uniform(0.15, 0.4)
    board = m.cardboard(rng)
    tape = tinted("smooth", (225.0, 200.0, 150.0), 0.15)
    if rng.uniform() < 0.6:
        tape_on_top = block(0, 0, height, (width, 0.05, 0.0015), tape)
        tape_down = block(width / 2 + 0.0006, 0, height * 0.7, (0.0012, 0.05, height * 0.3), tape)
        return Thing("box", (block(0, 0, 0, (width, depth, height), board), tape_on_top, tape_down))
    solids = _open_box((width, depth, height), 0.006, board)
    for side in (-1, 1):
        edge = (0.0, side * (depth / 2 - 0.003), height)
        end = (0.0, side * (depth / 2 + depth * 0.3), height - depth * rng.uniform(-0.3, 0.3))
        solids.append(beam(edge, end, width, 0.005, board))
    return Thing("box", tuple(solids))


def _open_box(size: Point, wall: float, material: Material) -> list[Solid]:
    width, depth, height = size
    solids = [block(0, 0, 0, (width - 2 * wall, depth - 2 * wall, wall), material)]
    solids += [block(s * (width - wall) / 2, 0, 0, (wall, depth, height), material) for s in (-1, 1)]
    return solids + [block(0, s * (depth - wall) / 2, 0, (width - 2 * wall, wall, height), material) for s in (-1, 1)]


def storage_bin(rng: np.random.Generator) -> Thing:
    """A plastic tub, wider at the top, with a rim and a lid."""
    x, y, height = rng.uniform(0.22, 0.32), rng.uniform(0.16, 0.22), rng.uniform(0.2, 0.38)
    body, lid = m.plastic(rng), m.plastic(rng)
    foot = (-x * 0.85, -y * 0.85, x * 0.85, y * 0.85)
    tub = tapered(foot, (-x, -y, x, y), 0, height - 0.03, body)
    cover = soft_box((-x - 0.015, -y - 0.015, height - 0.03), (x + 0.015, y + 0.015, height), (0.02, 0.02, 0.012), lid)
    return Thing(
        "storage bin",
        (tub, cover, *(block(s * (x + 0.01), 0, height - 0.05, (0.03, 0.12, 0.02), lid) for s in (-1, 1))),
    )


def crate(rng: np.random.Generator) -> Thing:
    """An open box of wooden slats on corner posts."""
    width, depth, height = rng.uniform(0.4, 0.6), rng.uniform(0.3, 0.4), rng.uniform(0.25, 0.35)
    wood = m.wood(rng)
    solids = [
        *legs(width - 0.03, depth - 0.03, height, 0.03, wood),
        block(0, 0, 0.01, (width - 0.03, depth - 0.03, 0.012), wood),
    ]
    step = height / 3
    for low in (i * step + 0.005 for i in range(3)):
        for side in (-1, 1):
            solids.append(block(0, side * (depth / 2 - 0.007), low, (width, 0.014, step - 0.03), wood))
            solids.append(block(side * (width / 2 - 0.007), 0, low + 0.002, (0.014, depth - 0.028, step - 0.034), wood))
    return Thing("crate", tuple(solids))


def trash_can(rng: np.random.Generator) -> Thing:
    """An open round waste bin with a rim, or a pedal bin with a lid."""
    radius, height = rng.uniform(0.12, 0.17), rng.uniform(0.28, 0.42)
    skin = m.metal(rng) if rng.uniform() < 0.5 else m.plastic(rng)
    if rng.uniform() < 0.5:
        profile = [
            (0, 0),
            (radius * 0.8, 0),
            (radius, height),
            (radius - 0.012, height),
            (radius * 0.78, 0.015),
            (0, 0.015),
        ]
        return Thing("trash can", (lathe(profile, skin, sides=16),))
    dark = m.dark_plastic(rng)
    lid = lathe(
        [
            (0, height),
            (radius * 1.02, height),
            (radius * 1.02, height + 0.03),
            (radius * 0.6, height + 0.06),
            (0, height + 0.065),
        ],
        skin,
        sides=14,
    )
    pedal = block(0, radius + 0.015, 0.006, (0.07, 0.07, 0.014), dark)
    return Thing(
        "trash can", (cylinder(radius * 1.03, 0, 0.04, dark, 14), cylinder(radius, 0.03, height, skin, 14), lid, pedal)
    )


def recycling_bin(rng: np.random.Generator) -> Thing:
    """A tall blue or green bin with a lid that has a slot, and two wheels."""
    width, depth, height = rng.uniform(0.36, 0.5), rng.uniform(0.36, 0.5), rng.uniform(0.6, 0.95)
    colours: tuple[Colour, ...] = ((45, 95, 165), (60, 130, 75), (215, 175, 50))
    skin, dark = tinted("smooth", m.around(rng, colours), 0.15), m.dark_plastic(rng)
    x, y = width / 2, depth / 2
    body = tapered((-x * 0.8, -y * 0.8, x * 0.8, y * 0.8), (-x, -y, x, y), 0.02, height, skin)
    lid = tapered(
        (-x - 0.015, -y - 0.015, x + 0.015, y + 0.02),
        (-x * 0.9, -y * 0.8, x * 0.9, y * 0.85),
        height,
        height + 0.07,
        dark,
    )
    slot = block(0, 0, height + 0.07, (width * 0.5, 0.06, 0.004), m.black_glass())
    wheels = [turned(cylinder(0.06, -0.02, 0.02, dark, 10), "y", 90, (s * x * 0.75, -y * 0.8, 0.06)) for s in (-1, 1)]
    feet = block(0, y * 0.5, 0, (width * 0.5, 0.06, 0.03), dark)
    sign = block(0, 0, 0, (0.16, 0.003, 0.16), tinted("shapes", (240.0, 240.0, 240.0), 0.5, 0.3))
    front = y * (0.8 + 0.2 * (0.45 * height - 0.02) / (height - 0.02))
    lean = float(np.degrees(np.arctan2(0.2 * y, height - 0.02)))
    return Thing(
        "recycling bin", (body, lid, slot, *wheels, feet, turned(sign, "x", -lean, (0, front + 0.0005, height * 0.45)))
    )


def bucket(rng: np.random.Generator) -> Thing:
    """A bucket with a wire handle."""
    radius, height = rng.uniform(0.12, 0.16), rng.uniform(0.22, 0.3)
    profile = [
        (0, 0),
        (radius * 0.75, 0),
        (radius, height),
        (radius - 0.008, height),
        (radius * 0.73, 0.012),
        (0, 0.012),
    ]
    angles = np.linspace(0, np.pi, 6)
    arch = [((radius + 0.004) * float(np.cos(a)), 0.0, height - 0.02 + 0.1 * float(np.sin(a))) for a in angles]
    steel = m.metal(rng)
    wire = bars(arch, 0.006, 0.006, steel)
    return Thing("bucket", (lathe(profile, m.plastic(rng), sides=14), *wire))


def basket(rng: np.random.Generator) -> Thing:
    """A wicker basket with a handle arched over it."""
    radius, height = rng.uniform(0.15, 0.22), rng.uniform(0.14, 0.22)
    wicker = tinted("fabric", m.around(rng, ((190, 145, 90), (150, 105, 65))), 0.65, 0.25)
    outside = [(0, 0), (radius * 0.75, 0), (radius, height)]
    inside = [(radius - 0.012, height), (radius * 0.72, 0.012), (0, 0.012)]
    angles = np.linspace(0, np.pi, 7)
    arch = [
        (1.25 * radius * 0.96 * float(np.cos(a)), 0.0, height - 0.01 + 0.9 * height * float(np.sin(a))) for a in angles
    ]
    handle = bars(arch, 0.025, 0.01, wicker)
    return Thing("basket", (stretched(lathe([*outside, *inside], wicker, sides=14), (1.25, 1, 1)), *handle))


def laundry_basket(rng: np.random.Generator) -> Thing:
    """An open tub with a rim and two grips, clothes inside."""
    radius, height = rng.uniform(0.19, 0.24), rng.uniform(0.35, 0.55)
    weave = m.plastic(rng) if rng.uniform() < 0.5 else m.wood(rng)
    outside = [(0, 0), (radius * 0.8, 0), (radius, height)]
    rim = [(radius + 0.02, height), (radius + 0.02, height + 0.02), (radius - 0.01, height + 0.02)]
    inside = [(radius * 0.78, 0.02), (0, 0.02)]
    body = stretched(lathe([*outside, *rim, *inside], weave, sides=14), (1.25, 1, 1))
    heap = ball((0, 0, height - 0.05), (1.25 * 0.93 * radius, 0.93 * radius, 0.08), m.fabric(rng), 14, 4)
    return Thing("laundry basket", (body, heap))
