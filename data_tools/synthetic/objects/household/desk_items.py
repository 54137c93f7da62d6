"""Desk items: one maker per class, each varies size, proportions and colours."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from data_tools.synthetic.shapes import materials as m
from data_tools.synthetic.shapes.primitives import ball, bars, beam, block, cylinder, disc, prism, tetrahedron
from data_tools.synthetic.shapes.solids import Colour, Material, Solid
from data_tools.synthetic.shapes.thing import Thing, tinted
from data_tools.synthetic.shapes.transforms import fitted, shifted, stretched, turned

_COVERS: tuple[Colour, ...] = ((150, 36, 36), (34, 62, 112), (38, 92, 70), (52, 50, 54), (196, 120, 44), (92, 52, 88))


def book(rng: np.random.Generator) -> Thing:
    """One closed book, covers round a block of pages, or one that lies open."""
    lies_open = rng.uniform() < 0.3
    size = rng.uniform(0.15, 0.22), rng.uniform(0.22, 0.3), rng.uniform(0.02, 0.045)
    cover = Material("cover", m.around(rng, _COVERS, 14), m.hue(rng, (0.0, 0.25), (0.88, 0.97)), 0.5)
    parts, turn = (_opened if lies_open else _bound)(*size, cover), rng.uniform(-14, 14)
    return Thing("book", tuple(turned(part, "z", turn) for part in parts))


def _opened(width: float, depth: float, thick: float, cover: Material) -> list[Solid]:
    """Two covers flat on the table, with printed pages that swell on both sides of the fold."""
    page = Material("print", (86.0, 84.0, 82.0), (236.0, 231.0, 218.0), 0.24)
    width *= 0.85
    across = width * np.array([0.01, 0.96, 0.96, 0.4, 0.12])
    raised = 0.003 + thick * np.array([0.0, 0.0, 0.25, 0.6, 0.52])
    solids = [block(0, 0, 0, (2 * width, depth, 0.003), cover)]
    for side in (-1, 1):
        outline = np.column_stack([side * across, raised])[::side]
        leaf = turned(prism(outline, 0.006 - depth / 2, depth / 2 - 0.006, page), "x", 90)
        across_page = leaf.quads[..., 0] / width + (side < 0)
        solids.append(
            replace(leaf, uv=page.tile_m * np.stack([across_page, 0.5 - leaf.quads[..., 1] / depth], axis=-1))
        )
    return solids


def _bound(width: float, depth: float, thick: float, cover: Material) -> list[Solid]:
    pages = tinted("stripes", (240.0, 234.0, 215.0), 0.2, 0.1)
    boards = [fitted(block(0, 0, z, (width, depth, 0.003), cover)) for z in (0, thick - 0.003)]
    spine = block(-width / 2 + 0.0015, 0, 0.003, (0.003, depth, thick - 0.006), cover)
    return [*boards, spine, block(0, 0, 0.003, (width - 0.012, depth - 0.01, thick - 0.006), pages)]


def paper(rng: np.random.Generator) -> Thing:
    """A small pile of printed sheets."""
    ink = Material("notes", m.hue(rng, (0.1, 0.9), (0.1, 0.4)), m.hue(rng, (0.0, 0.15), (0.94, 0.98)), 0.3)
    size = (0.21, 0.297, rng.uniform(0.006, 0.03))
    return Thing("paper", (fitted(block(0, 0, 0, size, ink)),))


def ball_(rng: np.random.Generator) -> Thing:
    """A toy ball in two colours."""
    radius = rng.uniform(0.06, 0.12)
    skin = Material("stripes", m.hue(rng, (0.6, 0.9), (0.5, 0.8)), m.hue(rng, (0.2, 0.7), (0.85, 0.97)), 0.4)
    return Thing("ball", (ball((0, 0, radius), (radius, radius, radius), skin, 14, 8),))


def tissue_box(rng: np.random.Generator) -> Thing:
    """A printed box with a tissue sticking out."""
    width, depth, height = rng.uniform(0.2, 0.24), rng.uniform(0.1, 0.13), rng.uniform(0.07, 0.11)
    tissue = tinted("smooth", (250.0, 250.0, 250.0), 0.1, 0.3)
    slot = shifted(stretched(cylinder(0.03, 0, 0.0015, m.black_glass(), 10), (2, 1, 1)), 0, 0, height)
    peak = tetrahedron(
        [(-0.045, -0.004, height), (0.045, 0.012, height), (0.0, -0.03, height + 0.05), (0.015, 0.02, height + 0.075)],
        tissue,
    )
    return Thing("tissue box", (block(0, 0, 0, (width, depth, height), m.patterned(rng)), slot, peak))


def alarm_clock(rng: np.random.Generator) -> Thing:
    """A clock with two bells on two feet."""
    radius = rng.uniform(0.045, 0.06)
    case, dark = m.plastic(rng), m.dark_plastic(rng)
    center = radius + 0.012
    solids = [
        disc(radius, 0.05, (0, -0.025, center), case, 14),
        disc(radius * 0.85, 0.003, (0, 0.025, center), m.ceramic(rng), 14),
    ]
    solids += [
        beam((0, 0.03, center), (x * radius, 0.03, center + z * radius), 0.003, 0.006, dark)
        for x, z in ((0.4, 0.2), (-0.25, 0.55))
    ]
    solids += [
        beam((s * radius * 0.5, 0, center - radius * 0.7), (s * radius * 0.8, 0, 0.003), 0.012, 0.012, dark)
        for s in (-1, 1)
    ]
    bells = [
        ball((s * radius * 0.65, 0, center + radius * 0.92), (0.022, 0.022, 0.018), m.metal(rng), 8, 4) for s in (-1, 1)
    ]
    return Thing("alarm clock", (*solids, *bells))


def stuffed_animal(rng: np.random.Generator) -> Thing:
    """A sitting teddy bear."""
    fur = tinted("fabric", m.around(rng, ((165, 115, 70), (205, 175, 140), (120, 120, 125))), 0.4, 0.4)
    pale, dark = tinted("fabric", (225.0, 200.0, 165.0), 0.3, 0.4), m.black_glass()
    k = rng.uniform(0.8, 1.4)
    parts = [((0.0, 0.0, 0.11), (0.085, 0.07, 0.11), fur, 8), ((0.0, 0.01, 0.27), (0.075, 0.065, 0.07), fur, 8)]
    parts += [((s * 0.06, 0.0, 0.335), (0.028, 0.016, 0.028), fur, 5) for s in (-1, 1)]
    parts += [((s * 0.055, 0.085, 0.04), (0.035, 0.075, 0.035), fur, 6) for s in (-1, 1)]
    parts += [((s * 0.08, 0.025, 0.15), (0.03, 0.035, 0.07), fur, 6) for s in (-1, 1)]
    parts += [((0.0, 0.07, 0.255), (0.032, 0.028, 0.026), pale, 6)]
    solids = [ball(center, radii, cloth, sides, sides // 2) for center, radii, cloth, sides in parts]
    eyes = [block(x, 0.07, z, (0.012, 0.02, 0.012), dark) for x, z in ((-0.028, 0.285), (0.028, 0.285), (0, 0.262))]
    eyes[2] = shifted(eyes[2], 0, 0.025, 0)
    return Thing("stuffed animal", tuple(stretched(s, (k, k, k)) for s in (*solids, *eyes)))


def headphones(rng: np.random.Generator) -> Thing:
    """Headphones lying on their two ear pads, the arch of the head band between."""
    case, pad = m.dark_plastic(rng), m.leather(rng)
    half, high = rng.uniform(0.07, 0.085), rng.uniform(0.1, 0.13)
    angles = np.linspace(0, np.pi, 8)
    arch = [(half * float(np.cos(a)), 0.0, 0.045 + high * float(np.sin(a))) for a in angles]
    solids = bars(arch, 0.022, 0.008, case)
    for side in (-1, 1):
        solids.append(turned(cylinder(0.04, -0.012, 0.012, case, 10), "y", 90, (side * (half + 0.005), 0, 0.04)))
        solids.append(turned(cylinder(0.034, -0.01, 0.01, pad, 10), "y", 90, (side * (half - 0.016), 0, 0.04)))
    return Thing("headphones", tuple(solids))
