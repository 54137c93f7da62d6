"""How things stand to each other: on, in, under, against, next to. Read off their surfaces and boxes.

What carries a thing is seen beside it, not beneath it, since that is hidden: contact is looked for a little way round.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np

from razer.arrays import BoolArray, Float64Array
from razer.boxes.iou import box_containment
from razer.boxes.rtree_index import BoxIndex
from razer.semantics.upright_instance import UprightInstance

RelationKind = Literal["on", "in", "under", "against", "next to"]

NEAR_M = 0.3  # things farther apart than this do not stand next to each other
TOUCH_M = 0.08  # masks are shrunk and surfaces are rounded by the voxels: what touches is this far apart at most
BESIDE_M = 0.1  # how far round a thing its support is looked for
HEADROOM_M = 0.6  # what is under something is at most this far below
_CONTACTS = 3
_INSIDE = 0.7
_COVERED = 0.5
# Of the directions round a thing: legs of a table stand in few of them.
_SECTORS, _HALF_ROUND, _ALL_ROUND = 24, 0.5, 0.75
_SHARED_HEIGHT = 0.3


@dataclass(frozen=True, slots=True)
class Relation:
    """`source` is e.g. on `target`, ids both; distance_m between their surfaces."""

    source: int
    target: int
    relation: RelationKind
    distance_m: float


def relations(placed: Sequence[UprightInstance]) -> list[Relation]:
    """All relations, by source and target; of a pair that is merely next to each other the lower id is the source."""
    by_id = {thing.id: thing for thing in placed}
    index = BoxIndex()
    for thing in placed:
        index.put(thing.id, thing.box)
    edges = []
    for one in sorted(by_id.values(), key=lambda thing: thing.id):
        for other_id in index.near(one.box, max(NEAR_M, HEADROOM_M)):
            if other_id > one.id:
                edges += _between(one, by_id[other_id])
    return sorted(edges, key=lambda e: (e.source, e.target))


def _between(one: UprightInstance, other: UprightInstance) -> list[Relation]:
    distance_m = _distance_m(one, other)
    if distance_m > max(NEAR_M, HEADROOM_M):
        return []
    for thing, place in ((one, other), (other, one)):
        if relation := _relation(thing, place, distance_m):
            return [Relation(thing.id, place.id, relation, distance_m)]
    beside = not (one.stuff or other.stuff) and distance_m <= NEAR_M and _same_level(one, other)
    return [Relation(one.id, other.id, "next to", distance_m)] if beside else []


def _relation(thing: UprightInstance, place: UprightInstance, distance_m: float) -> RelationKind | None:
    """What `thing` is to `place`, if it is more than next to it."""
    if thing.stuff:
        return None
    if not place.stuff and is_in(thing, place):
        return "in"
    if distance_m <= 2 * TOUCH_M and is_on(thing, place):
        return "on"
    if not (place.stuff or place.is_wall) and is_under(thing, place):
        return "under"
    return "against" if distance_m <= TOUCH_M and is_against(thing, place) else None


def is_on(thing: UprightInstance, place: UprightInstance) -> bool:
    """Whether `place` has level surface at the lowest height of `thing`, beneath or beside it, and spans its middle."""
    if place.stuff and place.is_wall:
        return False
    bottom = thing.heights_m[0]
    level = place.level[np.abs(place.level[:, 2] - bottom) <= TOUCH_M]
    if len(level) < _CONTACTS or not place.spans(thing.box.center[:2], TOUCH_M):
        return False
    near = thing.plan.query(level[:, :2], distance_upper_bound=BESIDE_M)[0]
    return int(np.isfinite(near).sum()) >= _CONTACTS


def is_in(thing: UprightInstance, place: UprightInstance) -> bool:
    """Whether most of the box of `thing` lies in that of `place`, which surrounds it on all sides or covers it."""
    if thing.box.volume <= 0 or place.box.volume < 2 * thing.box.volume:
        return False
    if box_containment([thing.box], [place.box])[0] < _INSIDE:
        return False
    around = _surrounded(thing, place)
    return around >= _ALL_ROUND or (around >= _HALF_ROUND and _covered(thing, place) >= _COVERED)


def is_under(thing: UprightInstance, place: UprightInstance) -> bool:
    """Whether `place`, which is the larger, covers most of `thing`, seen from above, and not far above it."""
    return thing.box.volume < place.box.volume and _covered(thing, place) >= _COVERED


def is_against(thing: UprightInstance, place: UprightInstance) -> bool:
    """Whether `thing` touches the upright surface of a wall, or of what stands like one, and does not itself."""
    if not place.is_wall or (thing.is_wall and thing.box.volume > place.box.volume):
        return False
    steep = place.steep[_close_by(place.steep, thing)]
    if len(steep) < _CONTACTS:
        return False
    near = thing.tree.query(steep, distance_upper_bound=TOUCH_M)[0]
    return int(np.isfinite(near).sum()) >= _CONTACTS


def _distance_m(one: UprightInstance, other: UprightInstance) -> float:
    few, many = sorted((one, other), key=lambda thing: len(thing.points))
    return float(many.tree.query(few.sample)[0].min())


def _same_level(one: UprightInstance, other: UprightInstance) -> bool:
    """Whether their heights overlap."""
    (low, _, high), (other_low, _, other_high) = one.heights_m, other.heights_m
    shared = min(high, other_high) - max(low, other_low)
    return shared >= _SHARED_HEIGHT * min(high - low, other_high - other_low)


def _covered(thing: UprightInstance, place: UprightInstance) -> float:
    """The share of `thing`, seen from above, that has surface of `place` over it."""
    _, middle, top = thing.heights_m
    over = place.points[_close_by(place.points, thing, above_m=HEADROOM_M)]
    over = over[(over[:, 2] > middle) & (over[:, 2] < top + HEADROOM_M)]
    if len(over) == 0:
        return 0.0
    distances = thing.plan.query(over[:, :2], distance_upper_bound=TOUCH_M)
    rows = distances[1][np.isfinite(distances[0])]
    cells = np.unique(np.floor(thing.sample[:, :2] / TOUCH_M).astype(np.int64), axis=0)
    hit = np.unique(np.floor(thing.sample[rows, :2] / TOUCH_M).astype(np.int64), axis=0)
    return len(hit) / len(cells)


def _surrounded(thing: UprightInstance, place: UprightInstance) -> float:
    """In which share of the directions round `thing` there is surface of `place` at its height."""
    low, _, high = thing.heights_m
    around = place.points[(place.points[:, 2] >= low) & (place.points[:, 2] <= high)]
    toward = around[:, :2] - thing.box.center[:2]
    angle = np.arctan2(toward[:, 1], toward[:, 0])
    return len(np.unique(np.floor((angle / (2 * np.pi) + 0.5) * _SECTORS) % _SECTORS)) / _SECTORS


def _close_by(points: Float64Array, thing: UprightInstance, above_m: float = 0.0) -> BoolArray:
    """Which points (N, 3) lie in the bounds of `thing`, a little larger."""
    low, high = thing.bounds - TOUCH_M, thing.bounds + TOUCH_M
    return np.asarray(((points >= low[0]) & (points <= high[1] + [0, 0, above_m])).all(axis=1))
