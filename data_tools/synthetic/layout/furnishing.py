"""Furnishing of rooms from the catalogue: along walls, on each other, round tables, at windows."""

from __future__ import annotations

import numpy as np

from data_tools.synthetic.layout.building import SIDES, Room, Side
from data_tools.synthetic.layout.placement import YAW_DEG, Area, Placer, strip
from data_tools.synthetic.objects.catalogue import PIECES
from data_tools.synthetic.shapes.primitives import block
from data_tools.synthetic.shapes.thing import Thing, tinted

_USUALLY = 0.85
_LOW_M = 0.95
_CURTAIN_OUT_M = 0.18
_CURTAIN_TOP_M = 2.5


def piece(name: str, placer: Placer) -> Thing:
    """A piece of the catalogue as the placer's generator makes it."""
    return PIECES[name](placer.rng)


def along(placer: Placer, room: Room, side: Side, share: float) -> float:
    """About the place at a share of a wall's length, metres along it.

    Args:
        placer: the world so far, and its generator of random numbers.
        room: where.
        side: the wall.
        share: of the wall's length, where the middle is to be.
    """
    start, end = room.along(side)
    return start + share * (end - start) + float(placer.rng.uniform(-0.05, 0.05))


def against(placer: Placer, room: Room, side: Side, share: float, *names: str, z: float = 0.0) -> Thing | None:
    """Put a piece against a wall; None where none has room there.

    Args:
        placer: the world so far, and its generator of random numbers.
        room: where.
        side: the wall.
        share: of the wall's length, where the middle is to be.
        *names: pieces of the catalogue, the first that fits is taken.
        z: height of the lower edge, metres.
    """
    at = along(placer, room, side, share)
    return next((put for name in names if (put := placer.against(room, side, piece(name, placer), at, z))), None)


def load(
    placer: Placer,
    support: Thing | None,
    *names: str,
    level: int = 0,
    yaw_deg: float | None = None,
    area: Area | None = None,
) -> None:
    """Stand pieces on a support, most of them; what does not fit is left out.

    Args:
        placer: the world so far, and its generator of random numbers.
        support: what the pieces stand on; None = nothing is done.
        *names: pieces of the catalogue.
        level: which surface of the support, from above.
        yaw_deg: how the pieces are turned; None = at random.
        area: corners (x, y) between which they stand; None = anywhere.
    """
    for name in names:
        if support is not None and placer.rng.uniform() < _USUALLY:
            placer.on_top(support, _low_piece(name, placer), level=level, yaw_deg=yaw_deg, area=area)


def _low_piece(name: str, placer: Placer) -> Thing:
    """A piece that can stand on furniture: a table lamp, not a floor lamp."""
    while True:
        candidate = piece(name, placer)
        if candidate.bounds[1][2] < _LOW_M:
            return candidate


def scatter(placer: Placer, room: Room, *names: str) -> None:
    """Stand pieces on the floor along the walls, where there is room."""
    for name in names:
        for _ in range(12):
            side = SIDES[int(placer.rng.integers(len(SIDES)))]
            if against(placer, room, side, float(placer.rng.uniform(0.08, 0.92)), name):
                break


def table_with_chairs(placer: Placer, room: Room, table: str, chair: str, x: float, y: float) -> Thing | None:
    """A rectangular table along x with six equal chairs: two on each long side, one at each end.

    Args:
        placer: the world so far, and its generator of random numbers.
        room: where.
        table: its name in the catalogue.
        chair: its name in the catalogue.
        x: of the middle, metres.
        y: of the middle, metres.
    """
    top = piece(table, placer)
    while np.subtract(*top.bounds[::-1])[0] < 1.15:
        top = piece(table, placer)
    put = placer.on_floor(room, top, x, y)
    if put is None:
        return None
    seat = piece(chair, placer)
    low, high = put.bounds
    at = low[0] + (high[0] - low[0]) * np.array([placer.rng.uniform(0.22, 0.26), placer.rng.uniform(0.74, 0.78)])
    out = 0.16
    spots = [(at[0], low[1] - out, 0.0), (at[1], low[1] - out, 0.0)]
    spots += [(at[0], high[1] + out, 180.0), (at[1], high[1] + out, 180.0)]
    spots += [(low[0] - out, y, -90.0), (high[0] + out, y, 90.0)]
    for at_x, at_y, yaw in spots:
        draw_up(placer, room, seat, (float(at_x), float(at_y)), yaw, float(placer.rng.uniform(-5, 5)))
    return put


def _before(screen: Thing, desk: Thing, side: Side) -> Area:
    """The part of a desk before a screen on it, a little wider than that."""
    low, high = strip(desk, side, 0.5, 1.0)
    axis = 0 if side in ("south", "north") else 1
    left, right = screen.bounds[0][axis] - 0.1, screen.bounds[1][axis] + 0.1
    low[axis], high[axis] = max(low[axis], left), min(high[axis], right)
    return low, high


def draw_up(
    placer: Placer, room: Room, chair: Thing, at: tuple[float, float], yaw_deg: float, turn_deg: float = 0.0
) -> Thing | None:
    """Stand a chair at a place, or behind it, as near as there is room; None where there is none.

    Args:
        placer: the world so far, and its generator of random numbers.
        room: where.
        chair: the chair.
        at: the place (x, y), metres.
        yaw_deg: the direction in which it is drawn up.
        turn_deg: by how much it is turned away from that.
    """
    away = np.array([np.sin(np.radians(yaw_deg)), -np.cos(np.radians(yaw_deg))])
    for step in range(12):
        x, y = at + 0.04 * step * away
        if put := placer.on_floor(room, chair, float(x), float(y), yaw_deg + turn_deg):
            return put
    return None


def window(placer: Placer, room: Room, side: Side, share: float, z: float, *, curtains: bool = False) -> Thing | None:
    """Put a window into a wall, perhaps with curtains before it.

    Args:
        placer: the world so far, and its generator of random numbers.
        room: where.
        side: the wall.
        share: of the wall's length, where the middle is to be.
        z: height of the lower edge, metres.
        curtains: usually hang curtains before it.
    """
    at = along(placer, room, side, share)
    put = placer.against(room, side, piece("window", placer), at, z, gap=0.0)
    if put is not None and curtains and placer.rng.uniform() < _USUALLY:
        width = float(np.subtract(*put.bounds[::-1])[:2].max())
        drapes = _held_out(piece("curtain", placer))
        low, high = drapes.bounds
        bottom = min(_CURTAIN_TOP_M, room.height - 0.06) - float(high[2] - low[2])
        if high[0] - low[0] > width + 0.12 and bottom > 0:
            placer.against(room, side, drapes, at, bottom, gap=0.0)
    return put


def _held_out(curtain: Thing) -> Thing:
    """Curtains hung so far from the wall that a sill fits behind, on two brackets."""
    low, high = curtain.bounds
    steel = tinted("smooth", (120.0, 122.0, 126.0), 0.25)
    # The rod runs 6 cm before the back plane.
    reach = (0.02, _CURTAIN_OUT_M + 0.05, 0.02)
    brackets = [block(x, reach[1] / 2, high[2] - 0.024, reach, steel) for x in (low[0] + 0.03, high[0] - 0.03)]
    return Thing(curtain.class_name, (*curtain.placed(0, _CURTAIN_OUT_M).solids, *brackets))


def workplace(placer: Placer, room: Room, side: Side, share: float) -> Thing | None:
    """A desk at a wall with a computer whose user would face the wall, and an office chair.

    Args:
        placer: the world so far, and its generator of random numbers.
        room: where.
        side: the wall.
        share: of the wall's length, where the middle is to be.
    """
    desk = against(placer, room, side, share, "desk")
    if desk is None:
        return None
    yaw = YAW_DEG[side]
    screen = placer.on_top(desk, piece("monitor", placer), yaw_deg=yaw, area=strip(desk, side, 0.04, 0.6))
    before = _before(screen, desk, side) if screen else strip(desk, side, 0.5, 1.0)
    load(placer, desk, "keyboard", "mouse", yaw_deg=yaw + 180, area=before)
    load(placer, desk, "lamp", "cup", "telephone", "book", "paper", "headphones")
    low, high = desk.bounds
    seat, middle = piece("office chair", placer), (low + high)[:2] / 2
    out = np.array([-np.sin(np.radians(yaw)), np.cos(np.radians(yaw))])
    at = middle + out * (float(np.subtract(high, low)[:2] @ np.abs(out)) / 2 + 0.12)
    draw_up(placer, room, seat, (float(at[0]), float(at[1])), yaw + 180, float(placer.rng.uniform(-25, 25)))
    return desk
