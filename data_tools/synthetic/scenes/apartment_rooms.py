"""Furniture of the rooms of the apartment."""

from __future__ import annotations

import numpy as np

from data_tools.synthetic.layout.building import Room
from data_tools.synthetic.layout.furnishing import (
    against,
    along,
    load,
    piece,
    scatter,
    table_with_chairs,
    window,
    workplace,
)
from data_tools.synthetic.layout.placement import YAW_DEG, Placer, strip
from data_tools.synthetic.shapes.thing import Thing


def living_room(room: Room, placer: Placer) -> None:
    """A table with six equal chairs, a couch, a television and shelves."""
    table = table_with_chairs(placer, room, "table", "chair", room.high[0] - 1.55, room.center[1] - 0.35)
    load(placer, table, "bowl", "cup", "cup", "plate", "bottle", "book", "candle", "plate", "plate", "plate")
    couch = against(placer, room, "west", 0.42, "couch")
    load(placer, couch, "cushion", "cushion", "blanket")
    coffee_table = placer.on_floor(room, piece("coffee table", placer), room.low[0] + 1.75, room.center[1] - 0.35, 90)
    load(placer, coffee_table, "tray", "book", "tissue box")
    load(placer, against(placer, room, "south", 0.22, "tv stand"), "tv", yaw_deg=0.0)
    shelf = against(placer, room, "north", 0.15, "shelf")
    load(placer, shelf, "potted plant")
    for level in (1, 2, 3):
        load(placer, shelf, "book", "tissue box", level=level, yaw_deg=YAW_DEG["north"] + 90)
    against(placer, room, "west", 0.42, "picture", z=1.35)
    window(placer, room, "south", 0.75, 0.95, curtains=True)
    against(placer, room, "east", 0.4, "poster", z=1.2)
    against(placer, room, "north", 0.8, "clock", z=1.8)
    against(placer, room, "south", 0.72, "radiator")
    scatter(placer, room, "plant", "lamp", "armchair", "guitar", "speaker")


def kitchen(room: Room, placer: Placer) -> None:
    """Counters with appliances in a row along the south, a small table with stools."""
    window(placer, room, "east", 0.6, 1.1)
    tops = _kitchen_row(room, placer)
    load(placer, tops.get("counter"), "coffee maker", "toaster", "coffee kettle", "bowl", yaw_deg=0.0)
    load(placer, tops.get("kitchen cabinet"), "microwave", "bottle", "paper towel roll", yaw_deg=0.0)
    load(placer, tops.get("dishwasher"), "dish rack", yaw_deg=0.0)
    counter = against(placer, room, "east", 0.62, "counter")
    load(placer, counter, "microwave", yaw_deg=YAW_DEG["east"])
    load(placer, counter, "bowl", "water bottle", "plate", "cup")
    table = against(placer, room, "west", 0.6, "dining table", "dining table", "table")
    load(placer, table, "bowl", "cup", "plate", "bottle", "plate", "plate", "bowl")
    stool = piece("stool", placer)
    if table is not None:
        x = float(table.bounds[1][0]) + 0.3
        for y in np.linspace(float(table.bounds[0][1]) - 0.1, float(table.bounds[1][1]) - 0.2, 3):
            placer.on_floor(room, stool, x, float(y), float(placer.rng.uniform(0, 90)))
    against(placer, room, "west", 0.78, "clock", z=1.75)
    against(placer, room, "west", 0.5, "bulletin board", z=1.2)
    scatter(placer, room, "trash can", "recycling bin", "crate", "bucket")


def _kitchen_row(room: Room, placer: Placer) -> dict[str, Thing]:
    """Appliances side by side along the south wall as far as they fit, and a hood over the stove."""
    next_x, row = room.low[0] + 0.03, dict[str, Thing]()
    for name in ("refrigerator", "counter", "stove", "dishwasher", "kitchen cabinet"):
        new = piece(name, placer)
        width = float(new.bounds[1][0] - new.bounds[0][0])
        put = placer.against(room, "south", new, next_x + width / 2) if next_x + width < room.high[0] - 0.03 else None
        if put is not None:
            row[name], next_x = put, next_x + width + 0.02
    if stove := row.get("stove"):
        middle = float(stove.bounds[0][0] + stove.bounds[1][0]) / 2
        placer.against(room, "south", piece("range hood", placer), middle, 1.6, gap=0.0)
    return row


def bedroom(room: Room, placer: Placer) -> None:
    """A bed with nightstands, wardrobe, dresser and mirror."""
    _made_bed(room, placer)
    for share in (0.1, 0.92):
        load(placer, against(placer, room, "west", share, "nightstand"), "lamp", "alarm clock", "book", "cup")
    against(placer, room, "east", 0.75, "wardrobe")
    dresser = against(placer, room, "north", 0.62, "dresser")
    load(placer, dresser, "box", "headphones", "candle", "purse")
    against(placer, room, "north", 0.62, "mirror", z=1.2)
    against(placer, room, "west", 0.55, "picture", z=1.5)
    window(placer, room, "north", 0.2, 0.95, curtains=True)
    against(placer, room, "east", 0.2, "poster", z=1.2)
    against(placer, room, "south", 0.2, "clock", z=1.8)
    scatter(placer, room, "laundry basket", "suitcase", "backpack", "ottoman", "lamp")


def _made_bed(room: Room, placer: Placer) -> None:
    """A bed with pillows at its head and a blanket on the rest."""
    bed = against(placer, room, "west", 0.55, "bed")
    if bed is not None:
        head, rest = strip(bed, "west", 0.02, 0.36), strip(bed, "west", 0.4, 1.0)
        load(placer, bed, "pillow", "pillow", yaw_deg=YAW_DEG["west"], area=head)
        load(placer, bed, "blanket", "stuffed animal", area=rest)


def bathroom(room: Room, placer: Placer) -> None:
    """Bathtub along the north, toilet and sink, a washing machine."""
    against(placer, room, "north", 0.5, "bathtub", "shower")
    against(placer, room, "west", 0.5, "toilet")
    at = along(placer, room, "east", 0.5)
    if placer.against(room, "east", piece("sink", placer), at):
        placer.against(room, "east", piece("mirror", placer), at, 1.25, gap=0.0)
    load(placer, against(placer, room, "east", 0.16, "washing machine"), "basket", "bottle")
    against(placer, room, "west", 0.2, "towel", z=0.9)
    scatter(placer, room, "trash can", "laundry basket", "toilet paper", "mat")


def study(room: Room, placer: Placer) -> None:
    """A desk with a computer, shelves and boxes."""
    window(placer, room, "east", 0.5, 1.05)
    workplace(placer, room, "east", 0.5)
    against(placer, room, "north", 0.3, "bookshelf")
    cabinet = against(placer, room, "west", 0.6, "file cabinet")
    load(placer, cabinet, "printer", yaw_deg=YAW_DEG["west"])
    load(placer, cabinet, "potted plant")
    against(placer, room, "west", 0.5, "whiteboard", z=1.45)
    shelf = against(placer, room, "north", 0.75, "shelf")
    for level in (0, 1, 2, 3):
        load(placer, shelf, "book", "paper", "book", level=level, yaw_deg=YAW_DEG["north"] + 90)
    scatter(placer, room, "computer tower", "box", "trash can", "fan")


def hall(room: Room, placer: Placer) -> None:
    """Doors at both ends, a coat rack and what one drops on coming home."""
    against(placer, room, "west", 0.5, "door")
    against(placer, room, "east", 0.5, "door")
    load(placer, against(placer, room, "south", 0.06, "end table", "nightstand"), "telephone", "purse")
    against(placer, room, "north", 0.07, "coat rack")
    for share in (0.16, 0.85):
        against(placer, room, "north", share, "picture", z=1.4)
    against(placer, room, "south", 0.48, "bulletin board", z=1.3)
    scatter(placer, room, "fire extinguisher", "bag")
