"""Furniture from boxes and surfaces of revolution. Every piece stands at z = 0 around the origin, faces +y
where it has a front, and is measured in metres."""

from __future__ import annotations

import numpy as np

from data_tools.synthetic.shapes.primitives import block, legs
from data_tools.synthetic.shapes.solids import Material, Point, box, lathe
from data_tools.synthetic.shapes.thing import Thing, tinted
from razer.arrays import Float64Array


def table(width: float, depth: float, height: float, top: Material, frame: Material) -> Thing:
    """A table top of 5 cm on four legs.

    Args:
        width: metres.
        depth: metres.
        height: metres.
        top: material of the top.
        frame: material of the legs.
    """
    solids = legs(width - 0.1, depth - 0.1, height - 0.05, 0.06, frame)
    return Thing("table", (*solids, block(0, 0, height - 0.05, (width, depth, 0.05), top)))


def chair(frame: Material, cushion: Material) -> Thing:
    """A dining chair of 44 x 46 x 90 cm: four legs, a thick seat, a padded back behind (-y)."""
    solids = legs(0.42, 0.42, 0.41, 0.05, frame)
    seat = block(0, 0, 0.41, (0.44, 0.44, 0.06), cushion)
    return Thing("chair", (*solids, seat, block(0, -0.19, 0.47, (0.42, 0.06, 0.43), cushion)))


def sofa(width: float, fabric: Material, class_name: str = "couch") -> Thing:
    """A sofa or armchair of 80 cm depth: base, back and two arms."""
    base = block(0, 0.08, 0, (width - 0.36, 0.64, 0.42), fabric)
    back = block(0, -0.32, 0, (width - 0.36, 0.16, 0.82), fabric)
    arms = [block(side * (width / 2 - 0.09), 0, 0, (0.18, 0.8, 0.6), fabric) for side in (-1, 1)]
    return Thing(class_name, (base, back, *arms))


def cabinet(width: float, depth: float, height: float, body: Material, doors: Material) -> Thing:
    """A sideboard with proud doors on the front.

    Args:
        width: metres.
        depth: metres.
        height: metres.
        body: material of the box.
        doors: material of the doors.
    """
    count = max(1, round(width / 0.45))
    panel = width / count
    centers = [(i + 0.5) * panel - width / 2 for i in range(count)]
    fronts = [block(x, depth / 2 + 0.01, 0.06, (panel - 0.04, 0.02, height - 0.12), doors) for x in centers]
    return Thing("cabinet", (block(0, 0, 0, (width, depth, height), body), *fronts))


def shelf(width: float, depth: float, height: float, boards: int, wood: Material) -> Thing:
    """An open shelf: two sides, a back panel and equally spaced boards of 4 cm, the lowest on the floor.

    Args:
        width: metres.
        depth: metres.
        height: metres.
        boards: how many.
        wood: material.
    """
    sides = [block(s * (width / 2 - 0.02), 0, 0, (0.04, depth, height), wood) for s in (-1, 1)]
    back = block(0, -depth / 2 + 0.01, 0, (width - 0.08, 0.02, height), wood)
    bottoms = shelf_heights(height, boards) - 0.04
    inner = (width - 0.08, depth - 0.02, 0.04)
    return Thing("shelf", (*sides, back, *(block(0, 0.01, float(z), inner, wood) for z in bottoms)))


def shelf_heights(height: float, boards: int) -> Float64Array:
    """The heights of the upper sides of a shelf's boards."""
    return np.linspace(0.04, height, boards)


def books(width: float, tall: float, rng: np.random.Generator) -> Thing:
    """A row of upright books of random sizes and colours, `width` metres long."""
    solids = []
    left = -width / 2
    while left < width / 2 - 0.03:
        thick = min(float(rng.uniform(0.03, 0.06)), width / 2 - left)
        size = (thick, float(rng.uniform(0.16, 0.2)), tall * float(rng.uniform(0.8, 1.0)))
        red, green, blue = (float(c) for c in rng.uniform(50, 235, 3))
        cover = tinted("shapes", (red, green, blue), 0.5, 0.4)
        solids.append(block(left + thick / 2, 0, 0, size, cover))
        left += thick
    return Thing("book", tuple(solids))


def monitor(case: Material, screen: Material) -> Thing:
    """A flat screen of 60 x 36 cm on a foot."""
    foot = block(0, 0, 0, (0.26, 0.18, 0.02), case)
    neck = block(0, -0.03, 0.02, (0.07, 0.05, 0.1), case)
    body = block(0, 0, 0.12, (0.6, 0.05, 0.36), case)
    return Thing("monitor", (foot, neck, body, block(0, 0.028, 0.135, (0.57, 0.006, 0.33), screen)))


def floor_lamp(metal: Material, shade: Material) -> Thing:
    """A floor lamp of 1.6 m with a conical shade."""
    foot = lathe([(0, 0), (0.15, 0), (0.15, 0.03), (0, 0.03)], metal)
    pole = lathe([(0.025, 0.03), (0.025, 1.25)], metal, sides=12)
    return Thing("lamp", (foot, pole, lathe([(0, 1.25), (0.21, 1.25), (0.13, 1.6), (0, 1.6)], shade)))


def mug(glaze: Material) -> Thing:
    """A mug of 9 cm with an opening and a handle."""
    body = lathe([(0, 0), (0.045, 0), (0.045, 0.1), (0.038, 0.1), (0.036, 0.012), (0, 0.012)], glaze)
    handle = [((0.045, -0.008, 0.02), (0.075, 0.008, 0.035)), ((0.045, -0.008, 0.07), (0.075, 0.008, 0.085))]
    grip = box((0.06, -0.008, 0.035), (0.075, 0.008, 0.07), glaze)
    return Thing("cup", (body, *(box(low, high, glaze) for low, high in handle), grip))


def bottle(glass: Material) -> Thing:
    """A bottle of 30 cm."""
    profile = [(0, 0), (0.042, 0), (0.042, 0.18), (0.018, 0.23), (0.018, 0.3), (0, 0.3)]
    return Thing("bottle", (lathe(profile, glass),))


def bowl(glaze: Material) -> Thing:
    """An open bowl of 26 cm."""
    profile = [(0, 0), (0.07, 0), (0.13, 0.08), (0.118, 0.08), (0.064, 0.014), (0, 0.014)]
    return Thing("bowl", (lathe(profile, glaze),))


def bin_(plastic: Material) -> Thing:
    """A waste bin, open at the top."""
    profile = [(0, 0), (0.12, 0), (0.15, 0.34), (0.14, 0.34), (0.112, 0.02), (0, 0.02)]
    return Thing("trash can", (lathe(profile, plastic),))


def plant(pot: Material, leaves: Material) -> Thing:
    """A pot with a bulky plant of 1.1 m."""
    foliage = [(0, 0.36), (0.12, 0.4), (0.24, 0.6), (0.2, 0.75), (0.22, 0.85), (0.1, 1.05), (0, 1.1)]
    body = lathe([(0, 0), (0.13, 0), (0.17, 0.3), (0, 0.3)], pot)
    return Thing("plant", (body, lathe([(0.03, 0.3), (0.03, 0.38)], pot, sides=8), lathe(foliage, leaves, sides=14)))


def panel(class_name: str, width: float, height: float, thick: float, rim: Material, face: Material) -> Thing:
    """A framed board on a wall behind it (-y): a picture or a door, its lower edge at z = 0.

    Args:
        class_name: of the thing.
        width: metres.
        height: metres.
        thick: how far it stands out, metres.
        rim: material of the frame.
        face: material of the middle.
    """
    frame = block(0, thick / 2, 0, (width, thick, height), rim)
    inside = block(0, thick + 0.003, 0.04, (width - 0.08, 0.006, height - 0.08), face)
    return Thing(class_name, (frame, inside))


def carton(size: Point, material: Material) -> Thing:
    """A closed box."""
    return Thing("box", (block(0, 0, 0, size, material),))
