"""Tables, desks and counters: one maker per class, each varies size, proportions and colours."""

from __future__ import annotations

import numpy as np

from data_tools.synthetic.shapes import materials as m
from data_tools.synthetic.shapes.primitives import block, cylinder, legs
from data_tools.synthetic.shapes.solids import Material, Solid
from data_tools.synthetic.shapes.thing import Thing


def _four_legged(
    width: float, depth: float, height: float, thick: float, leg: float, materials: tuple[Material, Material]
) -> list[Solid]:
    """A top on four legs joined by aprons below it; materials of top and frame."""
    top, frame = materials
    under = height - thick
    solids = [*legs(width - 0.06, depth - 0.06, under, leg, frame), block(0, 0, under, (width, depth, thick), top)]
    x, y = (width - 0.06 - leg) / 2, (depth - 0.06 - leg) / 2
    for side in (-1, 1):
        solids.append(block(0, side * y, under - 0.08, (2 * x - leg, leg * 0.5, 0.08), frame))
        solids.append(block(side * x, 0, under - 0.08, (leg * 0.5, 2 * y - leg, 0.08), frame))
    return solids


def table(rng: np.random.Generator) -> Thing:
    """A rectangular table on four legs."""
    size = rng.uniform(0.9, 1.4), rng.uniform(0.65, 0.85), rng.uniform(0.71, 0.77)
    pair = m.wood(rng), m.wood(rng) if rng.uniform() < 0.6 else m.metal(rng)
    return Thing("table", tuple(_four_legged(*size, rng.uniform(0.025, 0.045), rng.uniform(0.04, 0.07), pair)))


def dining_table(rng: np.random.Generator) -> Thing:
    """A long table on four legs, or a round one on a column."""
    height, top = rng.uniform(0.73, 0.77), m.wood(rng)
    if rng.uniform() < 0.6:
        size = rng.uniform(1.5, 2.1), rng.uniform(0.85, 1.0), height
        return Thing("dining table", tuple(_four_legged(*size, 0.04, rng.uniform(0.06, 0.09), (top, m.wood(rng)))))
    radius, frame = rng.uniform(0.5, 0.65), m.wood(rng)
    feet = [block(0, 0, 0, (radius * 1.3, 0.09, 0.05), frame), block(0, 0, 0.004, (0.09, radius * 1.3, 0.05), frame)]
    column = cylinder(0.06, 0.04, height - 0.035, frame, 12)
    return Thing("dining table", (*feet, column, cylinder(radius, height - 0.035, height, top, 24)))


def coffee_table(rng: np.random.Generator) -> Thing:
    """A low table with a shelf under its top."""
    width, depth, height = rng.uniform(0.85, 1.25), rng.uniform(0.5, 0.65), rng.uniform(0.36, 0.46)
    top, frame = m.wood_or_lacquer(rng), m.wood(rng)
    leg = rng.uniform(0.04, 0.06)
    under = block(0, 0, 0.1, (width - 0.06 - 2 * leg, depth - 0.08, 0.025), frame)
    return Thing("coffee table", (*_four_legged(width, depth, height, 0.035, leg, (top, frame)), under))


def end_table(rng: np.random.Generator) -> Thing:
    """A small round table on a column and a round foot."""
    radius, height = rng.uniform(0.2, 0.28), rng.uniform(0.45, 0.6)
    frame, top = m.metal(rng), m.wood_or_lacquer(rng)
    foot, column = cylinder(radius * 0.7, 0, 0.02, frame, 16), cylinder(0.025, 0.02, height - 0.025, frame, 8)
    return Thing("end table", (foot, column, cylinder(radius, height - 0.025, height, top, 20)))


def desk(rng: np.random.Generator) -> Thing:
    """A writing desk: a drawer unit on one side, legs on the other, a modesty panel behind."""
    width, depth, height = rng.uniform(1.1, 1.6), rng.uniform(0.6, 0.75), rng.uniform(0.72, 0.76)
    top, body, grip = m.wood_or_lacquer(rng), m.wood_or_lacquer(rng), m.metal(rng)
    side = float(rng.choice([-1, 1]))
    x, under = side * (width / 2 - 0.24), height - 0.03
    solids = [block(0, 0, under, (width, depth, 0.03), top), block(x, 0, 0, (0.42, depth - 0.08, under), body)]
    for i in range(3):
        low = 0.06 + i * (under - 0.08) / 3
        front = depth / 2 - 0.04
        solids.append(block(x, front + 0.008, low, (0.38, 0.016, (under - 0.08) / 3 - 0.02), top))
        solids.append(block(x, front + 0.023, low + (under - 0.08) / 6, (0.12, 0.014, 0.014), grip))
    solids.append(block(-side * (width / 2 - 0.04), 0, 0, (0.04, depth - 0.08, under), body))
    solids.append(block(-side * 0.18, -depth / 2 + 0.06, under - 0.35, (width - 0.48, 0.02, 0.35), body))
    return Thing("desk", tuple(solids))


def counter(rng: np.random.Generator) -> Thing:
    """A reception counter: panelled front, plinth, overhanging top."""
    width, depth, height = rng.uniform(1.2, 2.0), rng.uniform(0.5, 0.65), rng.uniform(0.95, 1.1)
    body, top, plinth = m.wood_or_lacquer(rng), m.stone(rng), m.metal(rng)
    count = round(width / 0.4)
    panel = (width - 0.1) / count
    solids = [block(0, 0, 0, (width - 0.14, depth - 0.14, 0.08), plinth)]
    solids.append(block(0, 0, 0.08, (width - 0.08, depth - 0.08, height - 0.12), body))
    solids.append(block(0, 0, height - 0.04, (width, depth, 0.04), top))
    for i in range(count):
        center = (i + 0.5) * panel - (width - 0.1) / 2
        solids.append(block(center, depth / 2 - 0.035, 0.14, (panel - 0.04, 0.012, height - 0.24), body))
    return Thing("counter", tuple(solids))


def tv_stand(rng: np.random.Generator) -> Thing:
    """A low open board with two compartments and short feet."""
    width, depth, height = rng.uniform(1.1, 1.7), rng.uniform(0.36, 0.45), rng.uniform(0.4, 0.55)
    wood, front = m.wood_or_lacquer(rng), m.wood_or_lacquer(rng)
    solids = legs(width - 0.1, depth - 0.1, 0.1, 0.04, m.metal(rng))
    solids += [block(0, 0, z, (width, depth, 0.025), wood) for z in (0.1, height - 0.025)]
    inner = height - 0.15
    solids += [block(s * (width / 2 - 0.0125), 0, 0.125, (0.025, depth, inner), wood) for s in (-1, 1)]
    solids += [block(s * width / 6, 0, 0.125, (0.025, depth - 0.04, inner), wood) for s in (-1, 1)]
    solids.append(block(0, -depth / 2 + 0.01, 0.125, (width - 0.05, 0.015, inner), wood))
    for side in (-1, 1):
        left, right = sorted((side * (width / 2 - 0.025), side * (width / 6 + 0.0125)))
        solids.append(block((left + right) / 2, depth / 2 - 0.02, 0.125, (right - left, 0.018, inner), front))
    return Thing("tv stand", tuple(solids))
