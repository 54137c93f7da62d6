"""All furniture by ScanNet200 name."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from data_tools.worlds import seats, storage_pieces, tables
from data_tools.worlds.furniture import Thing

# Each piece stands at z = 0 around the origin and faces +y, in metres; what hangs on a wall has its back at y = 0.
PIECES: dict[str, Callable[[np.random.Generator], Thing]] = {
    "chair": seats.chair,
    "office chair": seats.office_chair,
    "couch": seats.couch,
    "armchair": seats.armchair,
    "stool": seats.stool,
    "bench": seats.bench,
    "ottoman": seats.ottoman,
    "table": tables.table,
    "dining table": tables.dining_table,
    "coffee table": tables.coffee_table,
    "end table": tables.end_table,
    "desk": tables.desk,
    "counter": tables.counter,
    "tv stand": tables.tv_stand,
    "cabinet": storage_pieces.cabinet,
    "dresser": storage_pieces.dresser,
    "nightstand": storage_pieces.nightstand,
    "wardrobe": storage_pieces.wardrobe,
    "file cabinet": storage_pieces.file_cabinet,
    "bookshelf": storage_pieces.bookshelf,
    "shelf": storage_pieces.shelf,
    "box": storage_pieces.box,
    "storage bin": storage_pieces.storage_bin,
    "crate": storage_pieces.crate,
    "suitcase": storage_pieces.suitcase,
}
