"""Beds and everything of cloth: one maker per class, each varies size, proportions and colours."""

from __future__ import annotations

import numpy as np

from data_tools.synthetic.shapes import materials as m
from data_tools.synthetic.shapes.primitives import block, layered, legs, prism, rounded, soft_box, tube
from data_tools.synthetic.shapes.solids import Material, Solid
from data_tools.synthetic.shapes.thing import Thing
from data_tools.synthetic.shapes.transforms import fitted


def bed(rng: np.random.Generator) -> Thing:
    """A bed of 2 m, single or double: frame, headboard at its head (-y), mattress, and a duvet that hangs over the
    sides, its upper end turned back; pillows come apart."""
    width = float(rng.choice([0.9, 1.2, 1.4, 1.6, 1.8])) + 0.06
    rail, top = rng.uniform(0.28, 0.34), rng.uniform(0.5, 0.56)
    wood, sheet, duvet = m.wood_or_lacquer(rng), m.linen(rng), m.bedding(rng)
    low, high = (-width / 2 + 0.03, -1.0, rail - 0.08), (width / 2 - 0.03, 1.0, top)
    solids = [*legs(width, 2.06, rail - 0.13, 0.07, wood), soft_box(low, high, (0.03, 0.03, 0.03), sheet)]
    solids += [block(s * (width / 2 - 0.012), 0, rail - 0.13, (0.024, 2.0, 0.16), wood) for s in (-1, 1)]
    solids.append(block(0, 1.015, rail - 0.13, (width, 0.03, 0.2), wood))
    solids.append(block(0, -1.025, 0, (width, 0.05, rng.uniform(0.8, 1.15)), wood))
    start = -rng.uniform(0.3, 0.5)
    return Thing("bed", (*solids, *_duvet(width, start, rail, top, duvet, sheet)))


def _duvet(width: float, start: float, rail: float, top: float, duvet: Material, sheet: Material) -> list[Solid]:
    """A duvet from y = start to the foot of a bed, over a mattress of this height, and its end turned back."""
    low, high = (-width / 2 - 0.03, start, rail - 0.05), (width / 2 + 0.03, 0.99, top + 0.045)
    fold_low, fold_high = (low[0] - 0.004, start - 0.01, top + 0.01), (high[0] + 0.004, start + 0.26, top + 0.065)
    cover = soft_box(low, high, (0.06, 0.07, 0.06), duvet)
    return [cover, soft_box(fold_low, fold_high, (0.05, 0.025, 0.025), sheet)]


def mattress(rng: np.random.Generator) -> Thing:
    """A bare quilted mattress lying flat."""
    width, height = float(rng.choice([0.9, 1.2, 1.4])), rng.uniform(0.16, 0.24)
    cloth = m.linen(rng)
    parts = [((-width / 2, -1.0, 0.0), (width / 2, 1.0, height), 0.03)]
    solids = [soft_box(low, high, (bevel, bevel, bevel), cloth) for low, high, bevel in parts]
    return Thing("mattress", (*solids, block(0, 0, height / 2 - 0.012, (width + 0.012, 2.012, 0.024), m.fabric(rng))))


def _puffed(name: str, width: float, depth: float, height: float, cloth: Material) -> Thing:
    layers = [(0.6, 0.0), (0.88, 0.15), (1.0, 0.5), (0.88, 0.85), (0.6, 1.0)]
    return Thing(name, (layered([(width / 2 * k, depth / 2 * k, height * z) for k, z in layers], cloth),))


def pillow(rng: np.random.Generator) -> Thing:
    """A bed pillow lying flat."""
    return _puffed("pillow", rng.uniform(0.55, 0.8), rng.uniform(0.38, 0.5), rng.uniform(0.1, 0.15), m.linen(rng))


def cushion(rng: np.random.Generator) -> Thing:
    """A square sofa cushion lying flat."""
    side = rng.uniform(0.38, 0.5)
    cloth = m.patterned(rng) if rng.uniform() < 0.5 else m.fabric(rng)
    return _puffed("cushion", side, side, rng.uniform(0.1, 0.15), cloth)


def blanket(rng: np.random.Generator) -> Thing:
    """A blanket folded into three layers."""
    width, depth = rng.uniform(0.45, 0.65), rng.uniform(0.32, 0.45)
    cloth, thick = m.bedding(rng), rng.uniform(0.03, 0.05)
    shrink = [0.0, 0.01, 0.005]
    solids = [
        rounded(
            (-width / 2 + d, -depth / 2 + d, i * thick), (width / 2 - d, depth / 2, (i + 1) * thick), "x", 0.014, cloth
        )
        for i, d in enumerate(shrink)
    ]
    return Thing("blanket", tuple(solids))


def towel(rng: np.random.Generator) -> Thing:
    """A towel over a rail on the wall (back plane y = 0)."""
    width, drop = rng.uniform(0.35, 0.55), rng.uniform(0.45, 0.75)
    cloth = Material("stripes", m.hue(rng, (0.2, 0.6), (0.5, 0.8)), m.hue(rng, (0.0, 0.2), (0.85, 0.97)), 0.7)
    rail = m.metal(rng)
    short, reach = drop * rng.uniform(0.1, 0.35), width / 2 + 0.06
    solids = [tube((-reach, 0.07, drop), (reach, 0.07, drop), 0.012, rail, 8)]
    solids += [tube((s * (reach - 0.01), 0, drop), (s * (reach - 0.01), 0.075, drop), 0.014, rail, 8) for s in (-1, 1)]
    solids.append(block(0, 0.09, 0, (width, 0.012, drop), cloth))
    solids.append(block(0, 0.05, short, (width, 0.012, drop - short), cloth))
    return Thing(
        "towel",
        (*solids, rounded((-width / 2, 0.044, drop - 0.002), (width / 2, 0.096, drop + 0.022), "x", 0.01, cloth)),
    )


def mat(rng: np.random.Generator) -> Thing:
    """A rug or a door mat."""
    width = rng.uniform(0.6, 1.8)
    size = (width, width * rng.uniform(0.55, 0.7), rng.uniform(0.012, 0.02))
    weave = Material("carpet", m.hue(rng, (0.4, 0.8), (0.25, 0.5)), m.hue(rng, (0.2, 0.5), (0.7, 0.95)), 1.0)
    return Thing("mat", (fitted(block(0, 0, 0, size, weave)),))


def curtain(rng: np.random.Generator) -> Thing:
    """Two drawn-apart curtains of deep folds under a rod, hanging before a wall (back plane y = 0)."""
    return _hanging("curtain", rng, rng.uniform(1.4, 2.2), rng.uniform(1.9, 2.3), m.fabric(rng), rng.uniform(0.5, 0.85))


def shower_curtain(rng: np.random.Generator) -> Thing:
    """A closed curtain of a shower."""
    return _hanging("shower curtain", rng, rng.uniform(0.9, 1.3), rng.uniform(1.8, 1.95), m.patterned(rng), 1.0)


def _hanging(name: str, rng: np.random.Generator, width: float, height: float, cloth: Material, closed: float) -> Thing:
    """Folds that cover the share `closed` of the width, from both ends, and the rod they hang from."""
    pitch, deep = rng.uniform(0.1, 0.13), rng.uniform(0.05, 0.08)
    count = max(2, round(closed * width / 2 / pitch))
    pitch = closed * width / 2 / count
    solids = [tube((-width / 2 - 0.08, 0.06, height), (width / 2 + 0.08, 0.06, height), 0.014, m.metal(rng), 8)]
    for side in (-1, 1):
        for i in range(count):
            center = side * (width / 2 - (i + 0.5) * pitch)
            half, flat = pitch * 0.58, pitch * 0.2
            y = 0.06 + 0.3 * deep * (i % 2)
            ring = [(half, 0), (flat, deep / 2), (-flat, deep / 2), (-half, 0), (-flat, -deep / 2), (flat, -deep / 2)]
            solids.append(prism(np.add(ring, (center, y)), 0, height - 0.005 * (i % 2), cloth))
    return Thing(name, tuple(solids))


def clothes(rng: np.random.Generator) -> Thing:
    """A pile of folded clothes."""
    bottom, solids = 0.0, []
    for _ in range(int(rng.integers(3, 6))):
        width, depth, thick = rng.uniform(0.26, 0.34), rng.uniform(0.22, 0.28), rng.uniform(0.025, 0.045)
        x, y = rng.uniform(-0.012, 0.012, 2)
        low, high = (x - width / 2, y - depth / 2, bottom), (x + width / 2, y + depth / 2, bottom + thick)
        solids.append(rounded(low, high, "x", thick * 0.4, m.fabric(rng)))
        bottom += thick
    return Thing("clothes", tuple(solids))
