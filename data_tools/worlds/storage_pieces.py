"""What things are kept in: one maker per class, each varies size, proportions and colours."""

from __future__ import annotations

import numpy as np

from data_tools.worlds import materials as m
from data_tools.worlds.furniture import Thing, tinted
from data_tools.worlds.shapes import beam, block, cylinder, legs, soft_box, tapered, tube, turned
from data_tools.worlds.solids import Material, Point, Solid


def drawers(
    center_x: float, front_y: float, low: float, high: float, width: float, rows: int, face: Material, grip: Material
) -> list[Solid]:
    """Proud drawer fronts with bar handles on a front plane, stacked between two heights."""
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
    """A row of proud doors with upright handles, the handles of each pair side by side."""
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
        solids += [s.moved(_shift(-(width - 0.06) / 2 + 0.01 + filled / 2, 0.01, low)) for s in row]
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


def _shift(x: float, y: float, z: float) -> np.ndarray:
    pose = np.eye(4)
    pose[:3, 3] = x, y, z
    return pose


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


def box(rng: np.random.Generator) -> Thing:
    """A cardboard box closed with a tape, sometimes with its flaps open."""
    width, depth, height = rng.uniform(0.25, 0.55), rng.uniform(0.2, 0.4), rng.uniform(0.15, 0.4)
    board = m.cardboard(rng)
    tape = tinted("smooth", (225.0, 200.0, 150.0), 0.15)
    if rng.uniform() < 0.6:
        tapes = [
            block(0, 0, height, (width, 0.05, 0.0015), tape),
            block(width / 2 + 0.0006, 0, height * 0.7, (0.0012, 0.05, height * 0.3), tape),
        ]
        return Thing("box", (block(0, 0, 0, (width, depth, height), board), *tapes))
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
        (tub, cover, *(block(s * (x + 0.02), 0, height - 0.05, (0.03, 0.12, 0.02), lid) for s in (-1, 1))),
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


def suitcase(rng: np.random.Generator) -> Thing:
    """An upright trolley case: ribbed shell, four wheels and a pulled-out handle."""
    width, depth, height = rng.uniform(0.38, 0.5), rng.uniform(0.22, 0.3), rng.uniform(0.5, 0.7)
    shell, dark = m.plastic(rng), m.dark_plastic(rng)
    low, high = (-width / 2, -depth / 2, 0.05), (width / 2, depth / 2, 0.05 + height)
    solids = [soft_box(low, high, (0.05, 0.04, 0.05), shell)]
    solids += [
        block(x, depth / 2 + 0.003, 0.12, (0.025, 0.012, height - 0.14), shell)
        for x in np.linspace(-0.3, 0.3, 5) * width
    ]
    solids += [
        turned(
            cylinder(0.027, -0.012, 0.012, dark, 8), "y", 90, (s * (width / 2 - 0.06), t * (depth / 2 - 0.06), 0.027)
        )
        for s in (-1, 1)
        for t in (-1, 1)
    ]
    top = 0.05 + height + rng.uniform(0.15, 0.4)
    solids += [
        tube((s * 0.09, -depth / 2 + 0.05, height), (s * 0.09, -depth / 2 + 0.05, top), 0.009, dark) for s in (-1, 1)
    ]
    return Thing("suitcase", (*solids, block(0, -depth / 2 + 0.05, top - 0.01, (0.22, 0.03, 0.03), dark)))
