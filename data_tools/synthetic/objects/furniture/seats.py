"""Seats: one maker per class, each varies size, proportions and colours."""

from __future__ import annotations

import numpy as np

from data_tools.synthetic.shapes import materials as m
from data_tools.synthetic.shapes.primitives import beam, block, bowed, cylinder, legs, rounded, soft_box, tapered, tube
from data_tools.synthetic.shapes.solids import Material, Solid
from data_tools.synthetic.shapes.thing import Thing
from data_tools.synthetic.shapes.transforms import turned

_LEAN_DEG = 10.0  # of the backs of sofas


def chair(rng: np.random.Generator) -> Thing:
    """A dining chair: tapered legs, rails, a padded or wooden seat, two leaning posts and a bowed back."""
    width, depth, seat = rng.uniform(0.4, 0.48), rng.uniform(0.4, 0.46), rng.uniform(0.43, 0.48)
    top = seat + rng.uniform(0.36, 0.5)
    frame = m.wood(rng)
    cloth = m.fabric(rng) if rng.uniform() < 0.5 else frame
    solids = _seat_on_legs(width, depth, seat, frame, cloth)
    ys = (-depth / 2 + 0.02, -depth / 2 - rng.uniform(0.02, 0.07))
    for side in (-1, 1):
        x = side * (width / 2 - 0.02)
        solids.append(beam((x, ys[0], seat - 0.021), (x, ys[1], top), 0.035, 0.03, frame))
    return Thing("chair", (*solids, *_back(rng, width - 0.076, (seat, top), ys, frame, cloth)))


def _seat_on_legs(width: float, depth: float, seat: float, frame: Material, cloth: Material) -> list[Solid]:
    """Four legs, rails between them, a board, and a cushion or a shaped seat on it."""
    under, x, y = seat - 0.05, width / 2 - 0.02, depth / 2 - 0.02
    solids = [_tapered_leg(s * x, y, under, frame) for s in (-1, 1)]
    solids += [_tapered_leg(s * x, -y, under, frame) for s in (-1, 1)]
    solids += [block(s * x, 0, under - 0.055, (0.02, depth - 0.07, 0.055), frame) for s in (-1, 1)]
    solids += [block(0, s * y, under - 0.055, (width - 0.07, 0.02, 0.055), frame) for s in (-1, 1)]
    solids.append(block(0, 0, under, (width, depth, 0.03), frame))
    thick = 0.05 if cloth is not frame else 0.022
    low, high = (-width / 2, -depth / 2 + 0.05, seat - 0.021), (width / 2, depth / 2 + 0.005, seat - 0.021 + thick)
    return [*solids, soft_box(low, high, (thick * 0.5, thick * 0.5, thick * 0.4), cloth)]


def _tapered_leg(x: float, y: float, height: float, material: Material) -> Solid:
    """A leg that is thinner at the floor."""
    foot = (x - 0.014, y - 0.014, x + 0.014, y + 0.014)
    return tapered(foot, (x - 0.02, y - 0.02, x + 0.02, y + 0.02), 0, height, material)


def _back(
    rng: np.random.Generator,
    width: float,
    heights: tuple[float, float],
    ys: tuple[float, float],
    frame: Material,
    cloth: Material,
) -> list[Solid]:
    """A padded panel, or three or four broad slats, bowed, between posts that lean from ys[0] at the seat to ys[1]."""
    slats = int(rng.integers(1, 5))
    seat, top = heights
    if cloth is not frame and slats <= 2:
        thick, made_of, spans = 0.035, cloth, [(seat + 0.03 + 0.05 * slats, top - 0.01)]
    else:
        slats = max(3, slats)
        pitch = (top - seat - 0.08) / slats
        thick, made_of = 0.018, frame
        spans = [(top - 0.01 - (i + 0.64) * pitch, top - 0.01 - i * pitch) for i in range(slats)]
    solids = []
    for low, high in spans:
        front = [float(np.interp(z, [seat, top], ys)) + thick / 2 for z in (low, high)]
        solids.append(bowed(width, 0.025, thick, (low, high), (front[0], front[1]), made_of))
    return solids


def office_chair(rng: np.random.Generator) -> Thing:
    """A swivel chair: a star of five feet with castors, a gas spring, seat, back and two arm rests."""
    seat, width = rng.uniform(0.44, 0.52), rng.uniform(0.46, 0.52)
    dark, cloth = m.dark_plastic(rng), m.fabric(rng) if rng.uniform() < 0.7 else m.leather(rng)
    solids = [cylinder(0.03, 0.06, seat - 0.05, dark, 8)]
    for angle in np.radians(np.arange(5) * 72 + 18):
        x, y = float(0.29 * np.cos(angle)), float(0.29 * np.sin(angle))
        solids.append(beam((0.1 * x, 0.1 * y, 0.1), (x, y, 0.06), 0.045, 0.028, dark))
        solids.append(turned(cylinder(0.03, -0.02, 0.02, dark, 6), "x", 90, (x, y, 0.026)))
    high = seat + rng.uniform(0.48, 0.68)
    solids.append(soft_box((-width / 2, -0.23, seat - 0.05), (width / 2, 0.24, seat + 0.03), (0.04, 0.05, 0.03), cloth))
    solids.append(beam((0, -0.22, seat - 0.03), (0, -0.29, seat + 0.2), 0.06, 0.02, dark))
    back = soft_box(
        (-width / 2 + 0.02, -0.035, 0), (width / 2 - 0.02, 0.035, high - seat - 0.1), (0.05, 0.02, 0.07), cloth
    )
    solids.append(turned(back, "x", rng.uniform(4, 12), (0, -0.25, seat + 0.1)))
    for side in (-1, 1):
        x = side * (width / 2 + 0.03)
        solids.append(block(side * (width / 2 - 0.02), 0, seat - 0.055, (0.13, 0.04, 0.025), dark))
        solids.append(block(x, 0, seat - 0.04, (0.03, 0.05, 0.23), dark))
        solids.append(block(x, 0, seat + 0.185, (0.07, 0.26, 0.025), dark))
    return Thing("office chair", tuple(solids))


def _padded(name: str, rng: np.random.Generator, width: float, seats: int) -> Thing:
    """A sofa of any width: feet, base, a leaning back, rolled arms, soft cushions on the seat and against the back."""
    depth, seat, back = rng.uniform(0.8, 0.95), rng.uniform(0.4, 0.46), rng.uniform(0.74, 0.9)
    arm, arm_top = rng.uniform(0.12, 0.2), rng.uniform(0.55, 0.66)
    cloth = m.leather(rng) if rng.uniform() < 0.25 else m.fabric(rng)
    foot = m.wood(rng)
    inner, half = width - 2 * arm, depth / 2
    solids = legs(width - 0.1, depth - 0.1, 0.08, 0.05, foot)
    solids.append(block(0, 0.02, 0.07, (inner, depth - 0.08, seat - 0.2), cloth))
    rest = rounded((-inner / 2 + 0.001, -0.075, 0), (inner / 2 - 0.001, 0.075, back - 0.2), "x", 0.04, cloth)
    solids.append(turned(rest, "x", _LEAN_DEG, (0, -half + 0.17, 0.2)))
    for side in (-1, 1):
        low, high = sorted((side * (width / 2), side * (inner / 2)))
        solids.append(rounded((low, -half + 0.02, 0.065), (high, half - 0.015, arm_top), "y", 0.25 * arm, cloth))
    share = inner / seats - 0.003
    for center in ((i + 0.5) * inner / seats - inner / 2 for i in range(seats)):
        left, right = center - share / 2, center + share / 2
        front = (right, half + 0.01, seat + 0.02)
        solids.append(soft_box((left, -half + 0.2, seat - 0.135), front, (0.035, 0.045, 0.045), cloth))
        pad = rounded((left, -0.085, 0), (right, 0.085, back - seat + 0.05), "x", 0.055, cloth)
        solids.append(turned(pad, "x", _LEAN_DEG, (0, -half + 0.29, seat - 0.01)))
    return Thing(name, tuple(solids))


def couch(rng: np.random.Generator) -> Thing:
    """A sofa for two or three."""
    seats = int(rng.integers(2, 4))
    return _padded("couch", rng, 0.4 + seats * rng.uniform(0.56, 0.7), seats)


def armchair(rng: np.random.Generator) -> Thing:
    """A sofa for one."""
    return _padded("armchair", rng, rng.uniform(0.8, 0.98), 1)


def stool(rng: np.random.Generator) -> Thing:
    """A round seat on three or four splayed legs with rungs."""
    height, radius, count = rng.uniform(0.42, 0.72), rng.uniform(0.16, 0.2), int(rng.integers(3, 5))
    frame, seat = m.wood(rng), m.wood(rng)
    angles = [2 * np.pi * (i + 0.5) / count for i in range(count)]
    solids = [cylinder(radius, height - 0.04, height, seat, 16)]
    solids += [_splayed_leg(angle, radius, height, frame) for angle in angles]
    ring = [(radius * 0.93 * float(np.cos(a)), radius * 0.93 * float(np.sin(a)), height * 0.3) for a in angles]
    solids += [tube(a, b, 0.01, frame) for a, b in zip(ring, [*ring[1:], ring[0]], strict=True)]
    return Thing("stool", tuple(solids))


def _splayed_leg(angle: float, radius: float, height: float, frame: Material) -> Solid:
    """A leg under a seat of this radius that leaves the middle in this direction."""
    c, s = float(np.cos(angle)), float(np.sin(angle))
    out, reach = radius * 0.7, radius * 1.05
    foot = tapered((-0.015, -0.015, 0.015, 0.015), (-0.018, -0.018, 0.018, 0.018), 0, height - 0.03, frame)
    shear = np.eye(4)
    shear[:2, 3] = reach * c, reach * s
    shear[:2, 2] = np.array([c, s]) * (out - reach) / height
    return foot.moved(shear)


def bench(rng: np.random.Generator) -> Thing:
    """A long backless seat of planks on two trestles."""
    width, depth, height = rng.uniform(1.0, 1.6), rng.uniform(0.32, 0.42), rng.uniform(0.42, 0.48)
    wood, frame = m.wood(rng), m.metal(rng)
    plank = depth / 3
    solids = [block(0, (i - 1) * plank, height - 0.04, (width, plank - 0.012, 0.04), wood) for i in range(3)]
    for side in (-1, 1):
        x = side * (width / 2 - 0.15)
        solids.append(block(x, 0, height - 0.08, (0.06, depth - 0.04, 0.04), frame))
        solids.append(block(x, 0, 0.12, (0.04, depth - 0.15, 0.04), frame))
        for end in (-1, 1):
            y = end * (depth / 2 - 0.05)
            solids.append(block(x, y, 0, (0.05, 0.05, height - 0.08), frame))
    return Thing("bench", (*solids, block(0, 0, 0.12, (width - 0.34, 0.04, 0.036), frame)))


def ottoman(rng: np.random.Generator) -> Thing:
    """A soft footstool on short feet."""
    width, depth, height = rng.uniform(0.45, 0.75), rng.uniform(0.4, 0.55), rng.uniform(0.36, 0.45)
    cloth = m.leather(rng) if rng.uniform() < 0.4 else m.fabric(rng)
    solids = legs(width - 0.06, depth - 0.06, 0.08, 0.045, m.wood(rng))
    body = soft_box((-width / 2, -depth / 2, 0.075), (width / 2, depth / 2, height - 0.1), (0.02, 0.02, 0.02), cloth)
    pad = soft_box((-width / 2, -depth / 2, height - 0.11), (width / 2, depth / 2, height), (0.04, 0.04, 0.04), cloth)
    return Thing("ottoman", (*solids, body, pad))
