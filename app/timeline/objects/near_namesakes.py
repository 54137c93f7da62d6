"""Things of one name in one place: neighbours, or one thing that was mapped twice."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import combinations

import numpy as np

from razer.boxes.iou import box_containment
from razer.map_object import MapObject

MIN_SHARED = 0.1  # of the smaller box's volume; neighbours on a shelf share less


def near_namesakes(items: Sequence[MapObject]) -> list[tuple[MapObject, MapObject]]:
    """Pairs of things of one name whose boxes overlap, those that overlap most first; the one seen first in front."""
    things = [item for item in items if not item.is_stuff and item.class_name is not None]
    things.sort(key=lambda item: (item.first_frame, item.id))
    pairs = [(a, b) for a, b in combinations(things, 2) if a.class_name == b.class_name and _may_touch(a, b)]
    if not pairs:
        return []
    shared = box_containment([a.box for a, _ in pairs], [b.box for _, b in pairs])
    order = np.argsort(-shared, kind="stable")
    return [pairs[row] for row in order.tolist() if shared[row] >= MIN_SHARED]


def _may_touch(a: MapObject, b: MapObject) -> bool:
    reach_m = (np.linalg.norm(a.box.extent) + np.linalg.norm(b.box.extent)) / 2
    return bool(np.linalg.norm(a.box.center - b.box.center) < reach_m)
