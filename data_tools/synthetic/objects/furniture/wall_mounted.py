"""Wall-mounted objects, doors and windows: the back plane at y = 0, facing +y, the lower edge at z = 0."""

from __future__ import annotations

import numpy as np

from data_tools.synthetic.shapes import materials as m
from data_tools.synthetic.shapes.primitives import beam, block, disc, tube
from data_tools.synthetic.shapes.solids import Material, Solid
from data_tools.synthetic.shapes.thing import Thing, tinted
from data_tools.synthetic.shapes.transforms import fitted, shifted


def _frame(width: float, height: float, rim: float, thick: float, material: Material) -> list[Solid]:
    """Four bars round an opening: the uprights between the upper and the lower bar."""
    solids = [block(0, thick / 2, z, (width, thick, rim), material) for z in (0, height - rim)]
    inner = height - 2 * rim
    return solids + [block(s * (width - rim) / 2, thick / 2, rim, (rim, thick, inner), material) for s in (-1, 1)]


def _framed(name: str, width: float, height: float, rim: float, frame: Material, face: Material) -> Thing:
    """A sheet of 1.2 cm inside a frame of 2.5 cm; the whole texture spans the sheet."""
    sheet = fitted(block(0, 0.006, rim, (width - 2 * rim, 0.012, height - 2 * rim), face))
    return Thing(name, (*_frame(width, height, rim, 0.025, frame), sheet))


def picture(rng: np.random.Generator) -> Thing:
    """A framed landscape or an abstract painting."""
    width, height = rng.uniform(0.35, 1.1), rng.uniform(0.35, 0.8)
    texture = "landscape" if rng.uniform() < 0.6 else "shapes"
    art = Material(texture, m.hue(rng, (0.2, 0.5), (0.15, 0.35)), m.hue(rng, (0.05, 0.25), (0.88, 0.97)))
    frame = m.wood(rng) if rng.uniform() < 0.6 else m.metal(rng)
    return _framed("picture", width, height, rng.uniform(0.02, 0.05), frame, art)


def poster(rng: np.random.Generator) -> Thing:
    """A printed sheet without a frame."""
    width = rng.uniform(0.4, 0.7)
    art = Material("shapes", m.hue(rng, (0.2, 0.6), (0.25, 0.5)), m.hue(rng, (0.05, 0.3), (0.88, 0.97)))
    return Thing("poster", (fitted(block(0, 0.002, 0, (width, 0.004, width * rng.uniform(1.2, 1.5)), art)),))


def mirror(rng: np.random.Generator) -> Thing:
    """A framed mirror."""
    width, height = rng.uniform(0.4, 0.8), rng.uniform(0.6, 1.3)
    frame = m.wood(rng) if rng.uniform() < 0.5 else m.metal(rng)
    return _framed("mirror", width, height, rng.uniform(0.015, 0.05), frame, m.mirror_glass())


def whiteboard(rng: np.random.Generator) -> Thing:
    """A board with writing, an aluminium frame, a tray and pens."""
    width, height = rng.uniform(1.0, 2.0), rng.uniform(0.8, 1.2)
    silver = tinted("smooth", (190.0, 192.0, 196.0), 0.2)
    face = Material("notes", m.hue(rng, (0.5, 0.9), (0.3, 0.6)), (246.0, 247.0, 248.0))
    board = _framed("whiteboard", width, height, 0.025, silver, face)
    tray = block(0, 0.055, 0.004, (width * 0.5, 0.06, 0.012), silver)
    pens = [block(x, 0.055, 0.016, (0.12, 0.016, 0.016), m.plastic(rng)) for x in (-0.15, 0.02)]
    return Thing("whiteboard", (*board.solids, tray, *pens))


def blackboard(rng: np.random.Generator) -> Thing:
    """A green or black board with chalk writing in a wooden frame."""
    chalk = Material("notes", (232.0, 236.0, 230.0), m.around(rng, ((38, 66, 54), (44, 46, 48)), 5))
    return _framed("blackboard", rng.uniform(1.4, 2.4), rng.uniform(0.9, 1.2), 0.04, m.wood(rng), chalk)


def bulletin_board(rng: np.random.Generator) -> Thing:
    """A cork board with pinned papers."""
    width, height = rng.uniform(0.7, 1.2), rng.uniform(0.5, 0.9)
    board = _framed("bulletin board", width, height, 0.03, m.wood(rng), tinted("terrazzo", (196.0, 150.0, 100.0), 0.35))
    papers = []
    for i, x in enumerate(np.arange(-width / 2 + 0.15, width / 2 - 0.12, 0.19)):
        low = float(rng.uniform(0.06, height - 0.32))
        ink = Material("notes", (60.0, 60.0, 70.0), m.hue(rng, (0.0, 0.5), (0.9, 0.98)), 0.4)
        papers.append(fitted(block(float(x), 0.013, low, (0.15, 0.004, 0.2 if i % 2 else 0.25), ink)))
    return Thing("bulletin board", (*board.solids, *papers))


def sign(rng: np.random.Generator) -> Thing:
    """A sign: a green one to the exit, or a pale plate with a few words."""
    if rng.uniform() < 0.4:
        width, height, face = rng.uniform(0.3, 0.42), 0.16, Material("exit", (34.0, 128.0, 78.0), (240.0, 248.0, 242.0))
    else:
        width = rng.uniform(0.16, 0.26)
        height, face = width * 0.7, Material("notes", m.around(rng, ((50, 60, 80),)), (240.0, 240.0, 236.0), 0.4)
    board = block(0, 0.008, 0, (width, 0.016, height), m.metal(rng))
    return Thing("sign", (board, fitted(block(0, 0.017, 0.006, (width - 0.012, 0.002, height - 0.012), face))))


def window(rng: np.random.Generator) -> Thing:
    """A window with one or two casements before a bright sky, and a sill."""
    width, height = rng.uniform(0.8, 1.6), rng.uniform(1.0, 1.4)
    white, sky = m.lacquer(rng), Material("clouds", (150.0, 185.0, 220.0), (240.0, 246.0, 250.0), 1.4, "sky")
    solids = [shifted(s, 0, 0, 0.04) for s in _frame(width, height, 0.07, 0.06, white)]
    solids.append(block(0, 0.01, 0.11, (width - 0.14, 0.02, height - 0.14), sky))
    if width > 1.0:
        solids.append(block(0, 0.04, 0.11, (0.1, 0.05, height - 0.14), white))
    bar = 0.04 + height * 0.68
    span = (width - 0.24) / 2 if width > 1.0 else width - 0.14
    centers = (-0.05 - span / 2, 0.05 + span / 2) if width > 1.0 else (0.0,)
    solids += [block(x, 0.035, bar, (span, 0.03, 0.04), white) for x in centers]
    handle = block(0, 0.075, 0.04 + height * 0.45, (0.02, 0.02, 0.12), m.metal(rng))
    grip = (
        handle
        if width > 1.0
        else block(width / 2 - 0.035, 0.07, 0.04 + height * 0.45, (0.02, 0.02, 0.12), m.metal(rng))
    )
    return Thing("window", (*solids, grip, block(0, 0.08, 0, (width + 0.1, 0.16, 0.04), white)))


def door(rng: np.random.Generator) -> Thing:
    """A closed door leaf with panels and a handle inside its frame."""
    width, height = rng.uniform(0.78, 0.95), rng.uniform(1.98, 2.08)
    leaf, rim, brass = m.wood_or_lacquer(rng), m.lacquer(rng), m.metal(rng)
    solids = [block(s * (width / 2 + 0.035), 0.035, 0, (0.07, 0.07, height), rim) for s in (-1, 1)]
    solids.append(block(0, 0.035, height, (width + 0.14, 0.07, 0.07), rim))
    solids.append(block(0, 0.02, 0.006, (width - 0.002, 0.04, height - 0.007), leaf))
    rows = int(rng.integers(1, 4))
    share = (height - 0.3) / rows
    for row in range(rows):
        solids.append(block(0, 0.046, 0.17 + row * share, (width - 0.28, 0.012, share - 0.1), leaf))
    side = float(rng.choice([-1, 1]))
    x = side * (width / 2 - 0.06)
    solids.append(block(x, 0.044, 0.92, (0.04, 0.008, 0.2), brass))
    solids.append(tube((x, 0.045, 1.04), (x, 0.1, 1.04), 0.011, brass))
    return Thing("door", (*solids, tube((x + side * 0.011, 0.1, 1.04), (x - side * 0.12, 0.1, 1.04), 0.011, brass)))


def doorframe(rng: np.random.Generator) -> Thing:
    """The lining of an open doorway."""
    width, height, deep = rng.uniform(0.8, 1.0), rng.uniform(1.98, 2.1), rng.uniform(0.1, 0.16)
    wood = m.wood_or_lacquer(rng)
    posts = [block(s * (width / 2 + 0.045), deep / 2, 0, (0.09, deep, height), wood) for s in (-1, 1)]
    return Thing("doorframe", (*posts, block(0, deep / 2, height, (width + 0.18, deep, 0.09), wood)))


def blinds(rng: np.random.Generator) -> Thing:
    """A venetian blind: head rail, tilted slats, cords and a lower rail."""
    width, height, count = rng.uniform(0.7, 1.4), rng.uniform(0.9, 1.4), 20
    slat, cord = m.lacquer(rng), tinted("smooth", (200.0, 200.0, 196.0), 0.1)
    solids = [block(0, 0.035, height - 0.04, (width, 0.05, 0.04), slat), block(0, 0.035, 0, (width, 0.03, 0.02), slat)]
    tilt = rng.uniform(0.006, 0.02)
    for z in np.linspace(0.035, height - 0.06, count):
        solids.append(beam((0, 0.012, float(z) + tilt), (0, 0.058, float(z) - tilt), width - 0.01, 0.003, slat))
    cords = [block(s * width * 0.35, 0.035, 0.015, (0.006, 0.004, height - 0.05), cord) for s in (-1, 1)]
    return Thing("blinds", (*solids, *cords))


def clock(rng: np.random.Generator) -> Thing:
    """A round wall clock with hour marks and two hands."""
    radius = rng.uniform(0.13, 0.2)
    rim, dark = m.plastic(rng), m.dark_plastic(rng)
    center = (0.0, 0.0, radius)
    solids = [disc(radius, 0.03, center, rim, 20), disc(radius * 0.88, 0.004, (0, 0.03, radius), m.ceramic(rng), 20)]
    for i in range(12):
        out = np.array([np.sin(i * np.pi / 6), 0, np.cos(i * np.pi / 6)]) * radius
        long = 0.66 if i % 3 == 0 else 0.75
        start, end = (tuple(center + out * share + (0, 0.0355, 0)) for share in (long, 0.82))
        solids.append(beam(start, end, 0.004, 0.012 if i % 3 == 0 else 0.006, dark))
    for y, length, wide in ((0.036, 0.45, 0.014), (0.0365, 0.7, 0.009)):
        turn = rng.uniform(0, 2 * np.pi)
        tip = (radius * length * float(np.sin(turn)), y, radius * (1 + length * float(np.cos(turn))))
        solids.append(beam((0, y, radius), tip, 0.004, wide, dark))
    return Thing("clock", tuple(solids))


def radiator(rng: np.random.Generator) -> Thing:
    """A ribbed radiator on two feet, standing before a wall (back plane y = 0)."""
    sections, height, deep = int(rng.integers(9, 19)), rng.uniform(0.5, 0.75), rng.uniform(0.08, 0.12)
    white, pitch = m.lacquer(rng), 0.06
    width = sections * pitch
    centers = [(i + 0.5) * pitch - width / 2 for i in range(sections)]
    solids = [block(x, 0.03 + deep / 2, 0.1, (pitch * 0.75, deep, height), white) for x in centers]
    solids += [
        tube((-width / 2, 0.03 + deep / 2, z), (width / 2, 0.03 + deep / 2, z), 0.02, white)
        for z in (0.15, 0.05 + height)
    ]
    solids += [block(s * (width / 2 - 0.1), deep / 2 + 0.01, 0, (0.04, deep + 0.02, 0.12), white) for s in (-1, 1)]
    return Thing("radiator", tuple(solids))
