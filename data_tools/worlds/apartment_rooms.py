"""What stands in the rooms of the apartment."""

from __future__ import annotations

import numpy as np

from data_tools.worlds.building import Room, Side
from data_tools.worlds.catalogue import PIECES
from data_tools.worlds.furniture import Thing
from data_tools.worlds.placing import Placer

_USUALLY = 0.85


def _piece(name: str, placer: Placer) -> Thing:
    return PIECES[name](placer.rng)


def _against(placer: Placer, room: Room, side: Side, share: float, *names: str, z: float = 0.0) -> Thing | None:
    """Put the first piece that has room there to a wall, its middle at a share of the wall's length."""
    start, end = room.along(side)
    along = start + share * (end - start) + placer.rng.uniform(-0.05, 0.05)
    return next((put for name in names if (put := placer.against(room, side, _piece(name, placer), along, z))), None)


def _hang(placer: Placer, room: Room, side: Side, share: float, name: str, z: float) -> Thing | None:
    return _against(placer, room, side, share, name, z=z)


def _load(placer: Placer, support: Thing | None, *names: str, level: int = 0) -> None:
    """Stand pieces on a support, most of them; what finds no place is left out."""
    for name in names:
        if support is not None and placer.rng.uniform() < _USUALLY:
            placer.on_top(support, _piece(name, placer), level=level)


def _scatter(placer: Placer, room: Room, *names: str) -> None:
    """Stand pieces on the floor along the walls, where there is room."""
    for name in names:
        for _ in range(12):
            side: Side = ("south", "east", "north", "west")[int(placer.rng.integers(4))]
            if _against(placer, room, side, float(placer.rng.uniform(0.1, 0.9)), name):
                break


def living_room(room: Room, placer: Placer) -> None:
    """A table with six equal chairs, a couch, a television and shelves."""
    rng = placer.rng
    x, y = room.high[0] - 1.55, room.center[1] - 0.35
    table = placer.on_floor(room, _piece("table", placer), x, y)
    chair = _piece("chair", placer)
    if table is not None:
        low, high = table.bounds
        thirds = low[0] + (high[0] - low[0]) * np.array([rng.uniform(0.2, 0.25), rng.uniform(0.75, 0.8)])
        out = 0.16
        spots = [(thirds[0], low[1] - out, 0.0), (thirds[1], low[1] - out, 0.0)]
        spots += [(thirds[0], high[1] + out, 180.0), (thirds[1], high[1] + out, 180.0)]
        spots += [(low[0] - out, y, -90.0), (high[0] + out, y, 90.0)]
        for at_x, at_y, yaw in spots:
            _drawn_up(placer, room, chair, at_x, at_y, yaw + rng.uniform(-5, 5))
        _load(placer, table, "bowl", "cup", "cup", "plate", "bottle", "book", "candle")
    couch = _against(placer, room, "west", 0.42, "couch")
    _load(placer, couch, "cushion", "cushion", "blanket")
    coffee_table = placer.on_floor(room, _piece("coffee table", placer), room.low[0] + 1.75, room.center[1] - 0.35, 90)
    _load(placer, coffee_table, "tray", "book", "tissue box")
    _load(placer, _against(placer, room, "south", 0.22, "tv stand"), "tv")
    shelf = _against(placer, room, "north", 0.15, "shelf")
    _load(placer, shelf, "potted plant")
    for level in (1, 2, 3):
        _load(placer, shelf, "book", "box", level=level)
    _hang(placer, room, "west", 0.42, "picture", 1.35)
    _hang(placer, room, "south", 0.75, "window", 0.95)
    _hang(placer, room, "east", 0.4, "poster", 1.2)
    _hang(placer, room, "north", 0.8, "clock", 1.8)
    _against(placer, room, "south", 0.72, "radiator")
    _scatter(placer, room, "plant", "lamp", "armchair", "guitar", "speaker")


def _drawn_up(placer: Placer, room: Room, chair: Thing, x: float, y: float, yaw_deg: float) -> None:
    """Stand a chair at a table, as near as it can stand."""
    towards = {0: (0.0, -1.0), 1: (1.0, 0.0), 2: (0.0, 1.0), 3: (-1.0, 0.0)}[round(yaw_deg / 90) % 4]
    for step in range(12):
        if placer.on_floor(room, chair, x + towards[0] * 0.05 * step, y + towards[1] * 0.05 * step, yaw_deg):
            return


def kitchen(room: Room, placer: Placer) -> None:
    """Counters with appliances in a row along the south, a small table with stools."""
    rng = placer.rng
    here = room.low[0] + 0.03
    row = ["refrigerator", "counter", "stove", "dishwasher", "kitchen cabinet"]
    tops: dict[str, Thing] = {}
    for name in row:
        piece = _piece(name, placer)
        width = float(piece.bounds[1][0] - piece.bounds[0][0])
        put = placer.against(room, "south", piece, here + width / 2) if here + width < room.high[0] - 0.03 else None
        if put is not None:
            tops[name], here = put, here + width + 0.02
    if stove := tops.get("stove"):
        middle = float(stove.bounds[0][0] + stove.bounds[1][0]) / 2
        placer.against(room, "south", _piece("range hood", placer), middle, 1.6)
    _load(placer, tops.get("counter"), "coffee maker", "toaster", "coffee kettle", "bowl")
    _load(placer, tops.get("kitchen cabinet"), "microwave", "bottle", "paper towel roll")
    _load(placer, tops.get("dishwasher"), "dish rack")
    counter = _against(placer, room, "east", 0.62, "counter")
    _load(placer, counter, "microwave", "bowl", "water bottle", "plate", "cup")
    table = _against(placer, room, "west", 0.6, "dining table", "dining table", "table")
    _load(placer, table, "bowl", "cup", "plate", "bottle")
    stool = _piece("stool", placer)
    if table is not None:
        x = float(table.bounds[1][0]) + 0.3
        for y in np.linspace(float(table.bounds[0][1]) - 0.1, float(table.bounds[1][1]) - 0.2, 3):
            placer.on_floor(room, stool, x, float(y), float(rng.uniform(0, 90)))
    _hang(placer, room, "east", 0.6, "window", 1.15)
    _hang(placer, room, "west", 0.78, "clock", 1.75)
    _hang(placer, room, "west", 0.5, "bulletin board", 1.2)
    _scatter(placer, room, "trash can", "recycling bin", "crate", "bucket")


def bedroom(room: Room, placer: Placer) -> None:
    """A bed with nightstands, wardrobe, dresser and mirror."""
    bed = _against(placer, room, "west", 0.55, "bed")
    _load(placer, bed, "pillow", "pillow", "blanket", "stuffed animal")
    for share in (0.1, 0.92):
        _load(placer, _against(placer, room, "west", share, "nightstand"), "lamp", "alarm clock", "book", "cup")
    _against(placer, room, "east", 0.75, "wardrobe")
    dresser = _against(placer, room, "north", 0.62, "dresser")
    _load(placer, dresser, "box", "headphones", "candle", "purse")
    _hang(placer, room, "north", 0.62, "mirror", 1.2)
    _hang(placer, room, "west", 0.55, "picture", 1.5)
    _hang(placer, room, "east", 0.2, "poster", 1.2)
    _hang(placer, room, "south", 0.2, "clock", 1.8)
    _scatter(placer, room, "laundry basket", "suitcase", "backpack", "ottoman", "lamp")


def bathroom(room: Room, placer: Placer) -> None:
    """Bathtub along the north, toilet and sink, a washing machine."""
    _against(placer, room, "north", 0.5, "bathtub", "shower")
    _against(placer, room, "west", 0.5, "toilet")
    if _against(placer, room, "east", 0.5, "sink"):
        _hang(placer, room, "east", 0.5, "mirror", 1.25)
    washing_machine = _against(placer, room, "east", 0.16, "washing machine")
    _load(placer, washing_machine, "basket", "bottle")
    _hang(placer, room, "west", 0.2, "towel", 0.9)
    _scatter(placer, room, "trash can", "laundry basket", "toilet paper")


def study(room: Room, placer: Placer) -> None:
    """A desk with a computer, shelves and boxes."""
    rng = placer.rng
    desk = _against(placer, room, "east", 0.5, "desk")
    if desk is not None:
        placer.on_top(desk, _piece("monitor", placer), yaw_deg=90)
        placer.on_top(desk, _piece("keyboard", placer), yaw_deg=90)
        _load(placer, desk, "lamp", "cup", "telephone", "mouse", "paper")
        x = float(desk.bounds[0][0]) - 0.3
        for step in range(8):
            if placer.on_floor(
                room, _piece("office chair", placer), x - 0.06 * step, room.center[1], rng.uniform(-120, -60)
            ):
                break
    _against(placer, room, "north", 0.3, "bookshelf")
    cabinet = _against(placer, room, "west", 0.6, "file cabinet")
    _load(placer, cabinet, "printer", "potted plant")
    _hang(placer, room, "west", 0.5, "whiteboard", 1.45)
    _hang(placer, room, "east", 0.55, "window", 1.3)
    shelf = _against(placer, room, "north", 0.75, "shelf")
    for level in (0, 1, 2):
        _load(placer, shelf, "box", "book", "storage bin", level=level)
    _scatter(placer, room, "computer tower", "box", "trash can", "fan")


def hall(room: Room, placer: Placer) -> None:
    """Doors at both ends, a coat rack and what one drops on coming home."""
    _hang(placer, room, "west", 0.5, "door", 0.0)
    _hang(placer, room, "east", 0.5, "door", 0.0)
    _load(placer, _against(placer, room, "south", 0.06, "end table", "nightstand"), "telephone", "purse")
    _against(placer, room, "north", 0.07, "coat rack")
    for share in (0.16, 0.85):
        _hang(placer, room, "north", share, "picture", 1.4)
    _hang(placer, room, "south", 0.48, "bulletin board", 1.3)
    _scatter(placer, room, "fire extinguisher", "bag")
