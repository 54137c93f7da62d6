"""Cupboards, chests and shelves: one maker per class, each varies size, proportions and colours."""

from __future__ import annotations

import numpy as np

from data_tools.synthetic.shapes import materials as m
from data_tools.synthetic.shapes.primitives import block, legs
from data_tools.synthetic.shapes.solids import Material, Solid
from data_tools.synthetic.shapes.thing import Thing, tinted
from data_tools.synthetic.shapes.transforms import shifted


def drawers(
    center_x: float, front_y: float, low: float, high: float, width: float, rows: int, face: Material, grip: Material
) -> list[Solid]:
    """Proud drawer fronts with bar handles on a front plane, stacked between two heights.

    Args:
        center_x: of the stack, metres.
        front_y: of the plane the fronts stand on, metres.
        low: height where the stack begins, metres.
        high: height where it ends.
        width: of a front, metres.
        rows: how many drawers.
        face: material of the fronts.
        grip: material of the handles.
    """
    share = (high - low) / rows
    solids = []
    for row in range(rows):
        z = low + row * share
        solids.append(block(center_x, front_y + 0.009, z + 0.006, (width - 0.012, 0.018, share - 0.012), face))
        solids.append(block(center_x, front_y + 0.027, z + share * 0.62, (min(0.16, width * 0.4), 0.018, 0.014), grip))
    return solids


def doors(
    front_y: float, low: float, high: float, width: float, count: int, face: Material, grip: Material
) -> list[Solid]:
    """A row of proud doors with upright handles, the handles of each pair side by side.

    Args:
        front_y: of the plane the doors stand on, metres.
        low: height of their lower edge, metres.
        high: height of their upper edge.
        width: of the row, metres.
        count: how many doors.
        face: material of the doors.
        grip: material of the handles.
    """
    share = width / count
    solids = []
    for i in range(count):
        x = (i + 0.5) * share - width / 2
        solids.append(block(x, front_y + 0.009, low + 0.006, (share - 0.012, 0.018, high - low - 0.012), face))
        hinge = 1 if i % 2 == 0 else -1
        middle = low + (high - low) * (0.5 if high - low > 1 else 0.7)
        grip_x = x + hinge * (share / 2 - 0.045)
        solids.append(block(grip_x, front_y + 0.028, middle - 0.06, (0.016, 0.02, 0.12), grip))
    return solids


def cabinet(rng: np.random.Generator) -> Thing:
    """A sideboard with two to four doors on short feet."""
    width, depth, height = rng.uniform(0.8, 1.6), rng.uniform(0.35, 0.48), rng.uniform(0.7, 0.95)
    body, face, grip = m.wood_or_lacquer(rng), m.wood_or_lacquer(rng), m.metal(rng)
    solids = [
        *legs(width - 0.08, depth - 0.08, 0.1, 0.05, m.wood(rng)),
        block(0, 0, 0.1, (width, depth, height - 0.1), body),
    ]
    solids += doors(depth / 2, 0.12, height - 0.03, width - 0.02, max(2, round(width / 0.42)), face, grip)
    return Thing("cabinet", tuple(solids))


def dresser(rng: np.random.Generator) -> Thing:
    """A chest with two columns of drawers."""
    width, depth, height = rng.uniform(0.9, 1.4), rng.uniform(0.42, 0.52), rng.uniform(0.75, 1.0)
    body, grip = m.wood_or_lacquer(rng), m.metal(rng)
    face = body if rng.uniform() < 0.5 else m.wood_or_lacquer(rng)
    solids = [
        block(0, -0.01, 0, (width - 0.06, depth - 0.06, 0.06), body),
        block(0, 0, 0.06, (width, depth, height - 0.09), body),
    ]
    solids.append(block(0, 0.01, height - 0.03, (width + 0.03, depth + 0.04, 0.03), body))
    rows = int(rng.integers(3, 5))
    for side in (-1, 1):
        solids += drawers(side * width / 4, depth / 2, 0.08, height - 0.05, width / 2 - 0.02, rows, face, grip)
    return Thing("dresser", tuple(solids))


def nightstand(rng: np.random.Generator) -> Thing:
    """A bedside table: a drawer over an open compartment, on legs."""
    width, depth, height = rng.uniform(0.4, 0.52), rng.uniform(0.35, 0.42), rng.uniform(0.48, 0.62)
    body, face, grip = m.wood_or_lacquer(rng), m.wood_or_lacquer(rng), m.metal(rng)
    leg, middle = rng.uniform(0.1, 0.2), height - 0.19
    solids = legs(width - 0.02, depth - 0.02, leg, 0.04, m.wood(rng))
    solids.append(block(0, 0, leg, (width, depth, 0.02), body))
    solids += [block(s * (width / 2 - 0.01), 0, leg + 0.02, (0.02, depth, middle - leg - 0.02), body) for s in (-1, 1)]
    solids.append(block(0, -depth / 2 + 0.01, leg + 0.02, (width - 0.04, 0.02, middle - leg - 0.02), body))
    solids.append(block(0, 0, middle, (width, depth, 0.17), body))
    solids.append(block(0, 0.005, height - 0.02, (width + 0.02, depth + 0.03, 0.02), body))
    return Thing(
        "nightstand", (*solids, *drawers(0, depth / 2, middle + 0.01, height - 0.03, width - 0.02, 1, face, grip))
    )


def wardrobe(rng: np.random.Generator) -> Thing:
    """A tall cupboard with two or three doors, a plinth and a cornice."""
    width, depth, height = rng.uniform(0.9, 1.6), rng.uniform(0.55, 0.62), rng.uniform(1.85, 2.15)
    body, face, grip = m.wood_or_lacquer(rng), m.wood_or_lacquer(rng), m.metal(rng)
    solids = [
        block(0, -0.01, 0, (width - 0.04, depth - 0.04, 0.08), body),
        block(0, 0, 0.08, (width, depth, height - 0.12), body),
    ]
    solids.append(block(0, 0.015, height - 0.04, (width + 0.04, depth + 0.03, 0.04), body))
    return Thing(
        "wardrobe", (*solids, *doors(depth / 2, 0.1, height - 0.06, width - 0.02, round(width / 0.5), face, grip))
    )


def file_cabinet(rng: np.random.Generator) -> Thing:
    """A steel cabinet of two to four deep drawers."""
    rows = int(rng.integers(2, 5))
    width, depth, height = rng.uniform(0.4, 0.47), rng.uniform(0.5, 0.6), 0.06 + rows * rng.uniform(0.3, 0.33)
    steel = tinted("smooth", m.around(rng, ((150, 152, 150), (200, 200, 195), (95, 105, 110))), 0.15)
    solids = [block(0, 0, 0, (width, depth, height), steel)]
    return Thing(
        "file cabinet", (*solids, *drawers(0, depth / 2, 0.05, height - 0.02, width - 0.02, rows, steel, m.metal(rng)))
    )


def _open_case(width: float, depth: float, height: float, boards: int, wood: Material) -> list[Solid]:
    thick = 0.025
    solids = [block(s * (width - thick) / 2, 0, 0, (thick, depth, height), wood) for s in (-1, 1)]
    solids.append(block(0, -depth / 2 + 0.008, 0.001, (width - 2 * thick, 0.012, height - 0.002), wood))
    inner = (width - 2 * thick, depth - 0.016, thick)
    return solids + [block(0, 0.006, float(z), inner, wood) for z in np.linspace(0.05, height - thick - 0.002, boards)]


def bookshelf(rng: np.random.Generator) -> Thing:
    """A bookcase with a row of books on every board."""
    width, depth, height = rng.uniform(0.7, 1.0), rng.uniform(0.26, 0.32), rng.uniform(1.6, 2.05)
    boards = round(height / 0.38) + 1
    solids = _open_case(width, depth, height, boards, m.wood_or_lacquer(rng))
    for z in np.linspace(0.05, height - 0.027, boards)[:-1]:
        filled = (width - 0.1) * rng.uniform(0.55, 1.0)
        low, gap = float(z) + 0.026, (height - 0.1) / (boards - 1)
        row = _spines(rng, filled, depth, gap - 0.06)
        solids += [shifted(s, -(width - 0.06) / 2 + 0.01 + filled / 2, 0.01, low) for s in row]
    return Thing("bookshelf", tuple(solids))


def _spines(rng: np.random.Generator, width: float, depth: float, tall: float) -> list[Solid]:
    """Groups of books that share height and binding, `width` metres long, standing at z = 0."""
    cuts = np.sort(rng.uniform(0, width, 2))
    solids = []
    for left, right in zip([0, *cuts], [*cuts, width], strict=True):
        if right - left < 0.03:
            continue
        cover = Material("spines", m.hue(rng, (0.3, 0.8), (0.2, 0.45)), m.hue(rng, (0.1, 0.6), (0.7, 0.95)), 0.6)
        size = (right - left - 0.002, depth * rng.uniform(0.6, 0.75), tall * rng.uniform(0.7, 1.0))
        solids.append(block((left + right - width) / 2, 0, 0, size, cover))
    return solids


def shelf(rng: np.random.Generator) -> Thing:
    """An empty rack of boards on four posts."""
    width, depth, height = rng.uniform(0.7, 1.1), rng.uniform(0.3, 0.42), rng.uniform(1.2, 1.9)
    frame = m.metal(rng) if rng.uniform() < 0.5 else m.wood(rng)
    boards, board = round(height / 0.4) + 1, m.wood_or_lacquer(rng)
    solids = legs(width, depth, height, 0.035, frame)
    inner = (width - 0.004, depth - 0.072, 0.022)
    return Thing(
        "shelf", (*solids, *(block(0, 0, float(z), inner, board) for z in np.linspace(0.08, height - 0.03, boards)))
    )
