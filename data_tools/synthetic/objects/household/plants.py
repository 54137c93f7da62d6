"""Plants in pots: each varies size, proportions and colours."""

from __future__ import annotations

import numpy as np

from data_tools.synthetic.shapes import materials as m
from data_tools.synthetic.shapes.primitives import cylinder, tetrahedron
from data_tools.synthetic.shapes.solids import Material, Solid, lathe
from data_tools.synthetic.shapes.thing import Thing, tinted


def _leaf(base: np.ndarray, turn: float, rise: float, length: float, material: Material) -> Solid:
    """A leaf folded along its middle, from a point in a direction (radians) with its tip hanging."""
    out = np.array([np.cos(turn) * np.cos(rise), np.sin(turn) * np.cos(rise), np.sin(rise)])
    across, up = np.array([-np.sin(turn), np.cos(turn), 0]), np.array([0, 0, 0.12])
    middle = base + 0.5 * length * out + up * length
    tip = base + length * out - up * length * 0.8
    corners = np.stack([base, tip, middle + 0.2 * length * across, middle - 0.2 * length * across])
    return tetrahedron(corners, material)


def _foliage(
    rng: np.random.Generator, low: float, high: float, length: float, count: int, green: Material
) -> list[Solid]:
    """Leaves all round a stem, the lower ones longer and flatter."""
    solids = []
    for i, share in enumerate(np.linspace(0, 1, count)):
        base = np.array([0, 0, low + share * (high - low)])
        size = length * (1.15 - 0.5 * share) * rng.uniform(0.85, 1.15)
        solids.append(
            _leaf(base, i * 2.4 + rng.uniform(-0.3, 0.3), 0.1 + 1.0 * share + rng.uniform(-0.1, 0.1), size, green)
        )
    return solids


def _pot(radius: float, height: float, clay: Material) -> list[Solid]:
    earth = tinted("terrazzo", (95.0, 70.0, 52.0), 0.5, 0.3)
    profile = [
        (0, 0),
        (radius * 0.7, 0),
        (radius, height),
        (radius * 0.9, height),
        (radius * 0.88, height - 0.02),
        (0, height - 0.02),
    ]
    return [lathe(profile, clay, sides=10), cylinder(radius * 0.88, height - 0.03, height - 0.018, earth, 10)]


def plant(rng: np.random.Generator) -> Thing:
    """A tall foliage plant for the floor in a pot."""
    radius, height = rng.uniform(0.13, 0.18), rng.uniform(0.24, 0.34)
    top = rng.uniform(0.8, 1.2)
    stem = cylinder(0.018, height - 0.03, top, tinted("wood", (120.0, 95.0, 60.0), 0.4), 6)
    leaves = _foliage(rng, height + 0.1, top, 0.42, 22, m.leaves(rng))
    return Thing("plant", (*_pot(radius, height, m.glaze(rng)), stem, *leaves))


def potted_plant(rng: np.random.Generator) -> Thing:
    """A small bushy plant in a pot, for a table or a sill."""
    radius, height = rng.uniform(0.06, 0.09), rng.uniform(0.09, 0.13)
    top, green = height + rng.uniform(0.06, 0.12), m.leaves(rng)
    stem = cylinder(0.006, height - 0.02, top, green, 5)
    leaves = _foliage(rng, height - 0.01, top, 0.17, 20, green)
    clay = tinted("smooth", m.around(rng, ((190, 105, 75), (235, 230, 222), (90, 110, 120))), 0.3, 0.4)
    return Thing("potted plant", (*_pot(radius, height, clay), stem, *leaves))
