"""Tableware: one maker per class, each varies size, proportions and colours."""

from __future__ import annotations

from itertools import pairwise

import numpy as np

from data_tools.synthetic.shapes import materials as m
from data_tools.synthetic.shapes.primitives import beam, block, cylinder
from data_tools.synthetic.shapes.solids import Material, Solid, lathe
from data_tools.synthetic.shapes.thing import Thing, tinted


def cup(rng: np.random.Generator) -> Thing:
    """A mug with an opening and a handle."""
    radius, height = rng.uniform(0.036, 0.048), rng.uniform(0.08, 0.11)
    glaze, foot = m.glaze(rng), rng.uniform(0.75, 1.0)
    profile = [
        (0, 0),
        (radius * foot, 0),
        (radius, height),
        (radius - 0.006, height),
        (radius * foot - 0.008, 0.012),
        (0, 0.012),
    ]
    return Thing("cup", (lathe(profile, glaze, sides=16), *_ear(radius, foot, height, glaze)))


def _ear(radius: float, foot: float, height: float, glaze: Material) -> list[Solid]:
    """The handle of a cup, a bent bar; `foot` is the share of the radius at which its wall begins."""
    bend = [
        (radius * (foot + (1 - foot) * z) - 0.003 + out, 0.0, height * z)
        for z, out in ((0.2, 0.0), (0.24, 0.022), (0.42, 0.034), (0.62, 0.034), (0.78, 0.022), (0.82, 0.0))
    ]
    # Neighbours differ in width, so that their sides do not lie in one plane where they meet.
    return [beam(*ends, 0.012 - 0.0008 * (i % 2), 0.01, glaze) for i, ends in enumerate(pairwise(bend))]


def bottle(rng: np.random.Generator) -> Thing:
    """A wine or beer bottle with a label and a cap."""
    radius, height = rng.uniform(0.03, 0.042), rng.uniform(0.22, 0.32)
    glass = tinted("smooth", m.around(rng, ((50, 100, 60), (105, 65, 35), (150, 175, 165)), 10), 0.3)
    neck, label = radius * 0.4, Material("notes", m.hue(rng, (0.4, 0.9), (0.2, 0.5)), (240.0, 236.0, 220.0), 0.2)
    profile = [
        (0, 0),
        (radius, 0),
        (radius, height * 0.6),
        (neck, height * 0.76),
        (neck, height - 0.015),
        (0, height - 0.015),
    ]
    paper = lathe(
        [(0, height * 0.15), (radius + 0.001, height * 0.15), (radius + 0.001, height * 0.45), (0, height * 0.45)],
        label,
        sides=10,
    )
    return Thing(
        "bottle",
        (lathe(profile, glass, sides=10), paper, cylinder(neck + 0.003, height - 0.02, height, m.metal(rng), 8)),
    )


def water_bottle(rng: np.random.Generator) -> Thing:
    """A drinking bottle with a broad cap and a loop."""
    radius, height = rng.uniform(0.032, 0.04), rng.uniform(0.2, 0.27)
    body, cap = m.plastic(rng), m.dark_plastic(rng)
    profile = [(0, 0), (radius, 0), (radius, height * 0.75), (radius * 0.65, height * 0.85), (0, height * 0.85)]
    return Thing(
        "water bottle", (lathe(profile, body, sides=12), cylinder(radius * 0.68, height * 0.849, height, cap, 10))
    )


def bowl(rng: np.random.Generator) -> Thing:
    """An open bowl."""
    radius, height = rng.uniform(0.08, 0.14), rng.uniform(0.055, 0.09)
    profile = [
        (0, 0),
        (radius * 0.5, 0),
        (radius * 0.85, height * 0.5),
        (radius, height),
        (radius - 0.008, height),
        (radius * 0.5, 0.014),
        (0, 0.014),
    ]
    return Thing("bowl", (lathe(profile, m.glaze(rng), sides=14),))


def plate(rng: np.random.Generator) -> Thing:
    """A flat plate with a raised border."""
    radius = rng.uniform(0.1, 0.14)
    profile = [(0, 0), (radius * 0.6, 0), (radius, 0.02), (radius * 0.98, 0.024), (radius * 0.6, 0.006), (0, 0.006)]
    china = m.glaze(rng) if rng.uniform() < 0.25 else m.ceramic(rng)
    return Thing("plate", (lathe(profile, china, sides=16),))


def tray(rng: np.random.Generator) -> Thing:
    """A serving tray with a raised border and two grips."""
    width, depth = rng.uniform(0.38, 0.5), rng.uniform(0.26, 0.34)
    wood, grip = m.wood(rng), m.metal(rng)
    solids = [block(0, 0, 0, (width - 0.024, depth - 0.024, 0.012), wood)]
    solids += [block(s * (width - 0.012) / 2, 0, 0, (0.012, depth, 0.045), wood) for s in (-1, 1)]
    solids += [block(0, s * (depth - 0.012) / 2, 0, (width - 0.024, 0.012, 0.045), wood) for s in (-1, 1)]
    return Thing(
        "tray", (*solids, *(block(s * (width / 2 - 0.006), 0, 0.045, (0.02, 0.12, 0.015), grip) for s in (-1, 1)))
    )


def candle(rng: np.random.Generator) -> Thing:
    """A thick candle with a wick on a saucer."""
    radius, height = rng.uniform(0.025, 0.04), rng.uniform(0.08, 0.16)
    wax = tinted("smooth", m.hue(rng, (0.05, 0.6), (0.75, 0.97)), 0.15)
    saucer = lathe([(0, 0), (radius * 1.3, 0), (radius * 1.7, 0.014), (0, 0.008)], m.metal(rng), sides=12)
    return Thing(
        "candle",
        (saucer, cylinder(radius, 0.007, height, wax, 12), cylinder(0.002, height, height + 0.014, m.black_glass(), 4)),
    )
