"""Racks and pallets of a warehouse, and what is stored on them."""

from __future__ import annotations

import numpy as np

from data_tools.synthetic.layout.placement import Placer
from data_tools.synthetic.objects.catalogue import PIECES
from data_tools.synthetic.shapes import materials as m
from data_tools.synthetic.shapes.primitives import beam, block, legs
from data_tools.synthetic.shapes.thing import Thing, tinted

RACK_M = (2.3, 0.75)
BOARDS_M = (0.14, 1.05, 1.96)
_POST_M = 2.7
_STORED = ("box",) * 8 + ("storage bin", "storage bin", "crate", "basket", "bucket", "paper bag")
_HIGH_M = 0.78  # of what fits between two boards
_PALLET_M = (1.2, 0.8)


def rack(rng: np.random.Generator) -> Thing:
    """Boards between steel beams on four posts, braced at both ends."""
    width, deep = RACK_M
    blue = tinted("smooth", m.around(rng, ((40, 70, 140), (70, 78, 86), (60, 110, 80))), 0.12)
    orange = tinted("smooth", m.around(rng, ((216, 104, 40), (224, 160, 50))), 0.12)
    board = tinted("wood", m.around(rng, ((205, 170, 120), (185, 150, 105))), 0.25, 1.2)
    solids = legs(width, deep, _POST_M, 0.07, blue)
    for side in (-1, 1):
        x, y = side * (width / 2 - 0.035), deep / 2 - 0.07
        for low in BOARDS_M:
            solids.append(beam((x, -y, low + 0.1), (x, y, low + 0.6), 0.03, 0.02, blue))
    for z in BOARDS_M:
        solids.append(block(0, 0, z - 0.03, (width - 0.14, deep - 0.06, 0.03), board))
        solids += [block(0, s * (deep - 0.03) / 2, z - 0.12, (width - 0.14, 0.03, 0.12), orange) for s in (-1, 1)]
    return Thing("shelf", tuple(solids))


def fill_board(placer: Placer, support: Thing, height: float) -> None:
    """Stand stored things side by side on a board of a rack.

    Args:
        placer: the world so far, and its generator of random numbers.
        support: the rack, along x.
        height: of the board within it, metres.
    """
    rng = placer.rng
    (left, _, _), (right, _, _) = support.bounds
    middle = float(support.bounds[0][1] + support.bounds[1][1]) / 2
    x = left + 0.1 + float(rng.uniform(0, 0.15))
    while x < right - 0.4:
        thing = _stored(rng)
        low, high = thing.bounds
        put = thing.placed(float(x - low[0]), middle - float(low[1] + high[1]) / 2, height)
        if put.bounds[1][0] < right - 0.08 and placer.try_add(put) is not None:
            placer.arrangement.rests(put, support)
        x += float(high[0] - low[0]) + float(rng.choice([0.02, 0.05, 0.3], p=[0.5, 0.3, 0.2]))


def _stored(rng: np.random.Generator) -> Thing:
    """A piece that fits on a board."""
    while True:
        thing = PIECES[_STORED[int(rng.integers(len(_STORED)))]](rng)
        size = np.subtract(*thing.bounds[::-1])
        if size[1] < RACK_M[1] - 0.08 and size[2] < _HIGH_M:
            return thing


def pallet(rng: np.random.Generator) -> Thing:
    """A flat pallet of nine blocks between boards; ScanNet has no word for it but crate."""
    long, wide = _PALLET_M
    wood = tinted("wood", m.around(rng, ((200, 165, 118), (178, 148, 112))), 0.35, 0.9)
    solids = [block(0, s * (wide / 2 - 0.05), 0, (long, 0.1, 0.022), wood) for s in (-1, 0, 1)]
    solids += [
        block(a * (long / 2 - 0.07), b * (wide / 2 - 0.05), 0.022, (0.14, 0.1, 0.078), wood)
        for a in (-1, 0, 1)
        for b in (-1, 0, 1)
    ]
    solids += [block(a * (long / 2 - 0.07), 0, 0.1, (0.14, wide, 0.022), wood) for a in (-1, 0, 1)]
    rows = np.linspace(-wide / 2 + 0.05, wide / 2 - 0.05, 5)
    return Thing("crate", (*solids, *(block(0, float(y), 0.122, (long, 0.1, 0.022), wood) for y in rows)))


def load_pallet(placer: Placer, base: Thing) -> None:
    """Stack equal boxes on a pallet, one to three layers of them."""
    rng = placer.rng
    low, high = (corner[:2] for corner in base.bounds)
    size = high - low
    columns = (2, 1) if size[0] > size[1] else (1, 2)
    foot, tall = size / columns - 0.03, float(rng.uniform(0.3, 0.5))
    board = m.cardboard(rng)
    tape = tinted("smooth", (225.0, 200.0, 150.0), 0.15)
    z = float(base.bounds[1][2])
    for layer in range(int(rng.integers(1, 4))):
        for column in np.ndindex(columns):
            x, y = low + (np.array(column) + 0.5) * size / columns
            body = block(0, 0, 0, (float(foot[0]), float(foot[1]), tall), board)
            strip = block(0, 0, tall, (float(foot[0]), 0.05, 0.0015), tape)
            carton = Thing("box", (body, strip)).placed(float(x), float(y), z + layer * (tall + 0.0015))
            if placer.try_add(carton) is not None:
                placer.arrangement.rests(carton, base)
