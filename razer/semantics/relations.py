"""Spatial relations of instances, from their surfaces and boxes: on, in, under, against, next to.

What carries a thing is visible beside it, not beneath it: contact is looked for a little way round.
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


def relations(instances: Sequence[UprightInstance]) -> list[Relation]:
    """All relations, by source and target; of a pair that is merely next to each other the lower id is the source."""
    by_id = {instance.id: instance for instance in instances}
    index = BoxIndex()
    for instance in instances:
        index.put(instance.id, instance.box)
    edges = []
    for one in sorted(by_id.values(), key=lambda instance: instance.id):
        for other_id in index.near(one.box, max(NEAR_M, HEADROOM_M)):
            if other_id > one.id:
                edges += _between(one, by_id[other_id])
    return sorted(edges, key=lambda e: (e.source, e.target))


def _between(one: UprightInstance, other: UprightInstance) -> list[Relation]:
    distance_m = _distance_m(one, other)
    if distance_m > max(NEAR_M, HEADROOM_M):
        return []
    for source, target in ((one, other), (other, one)):
        if relation := _relation(source, target, distance_m):
            return [Relation(source.id, target.id, relation, distance_m)]
    beside = not (one.stuff or other.stuff) and distance_m <= NEAR_M and _same_level(one, other)
    return [Relation(one.id, other.id, "next to", distance_m)] if beside else []


def _relation(source: UprightInstance, target: UprightInstance, distance_m: float) -> RelationKind | None:
    """What `source` is to `target`, if it is more than next to it."""
    if source.stuff:
        return None
    if not target.stuff and is_in(source, target):
        return "in"
    if distance_m <= 2 * TOUCH_M and is_on(source, target):
        return "on"
    if not (target.stuff or target.is_wall) and is_under(source, target):
        return "under"
    return "against" if distance_m <= TOUCH_M and is_against(source, target) else None


def is_on(source: UprightInstance, target: UprightInstance) -> bool:
    """Whether `target` has level surface at the bottom of `source`, beneath or beside it, and spans its middle."""
    if target.stuff and target.is_wall:
        return False
    bottom = source.heights_m[0]
    level = target.level[np.abs(target.level[:, 2] - bottom) <= TOUCH_M]
    if len(level) < _CONTACTS or not target.spans(source.box.center[:2], TOUCH_M):
        return False
    near = source.plan.query(level[:, :2], distance_upper_bound=BESIDE_M)[0]
    return int(np.isfinite(near).sum()) >= _CONTACTS


def is_in(source: UprightInstance, target: UprightInstance) -> bool:
    """Whether most of the box of `source` lies in that of `target`, which surrounds it on all sides or covers it."""
    if source.box.volume <= 0 or target.box.volume < 2 * source.box.volume:
        return False
    if box_containment([source.box], [target.box])[0] < _INSIDE:
        return False
    around = _surrounded(source, target)
    return around >= _ALL_ROUND or (around >= _HALF_ROUND and _covered(source, target) >= _COVERED)


def is_under(source: UprightInstance, target: UprightInstance) -> bool:
    """Whether `target`, which is the larger, covers most of `source` from above, and not far above it."""
    return source.box.volume < target.box.volume and _covered(source, target) >= _COVERED


def is_against(source: UprightInstance, target: UprightInstance) -> bool:
    """Whether `source` touches the upright surface of a wall, or of what stands like one, and does not itself."""
    if not target.is_wall or (source.is_wall and source.box.volume > target.box.volume):
        return False
    steep = target.steep[_close_by(target.steep, source)]
    if len(steep) < _CONTACTS:
        return False
    near = source.tree.query(steep, distance_upper_bound=TOUCH_M)[0]
    return int(np.isfinite(near).sum()) >= _CONTACTS


def _distance_m(one: UprightInstance, other: UprightInstance) -> float:
    few, many = sorted((one, other), key=lambda instance: len(instance.points))
    return float(many.tree.query(few.sample)[0].min())


def _same_level(one: UprightInstance, other: UprightInstance) -> bool:
    """Whether their heights overlap."""
    (low, _, high), (other_low, _, other_high) = one.heights_m, other.heights_m
    shared = min(high, other_high) - max(low, other_low)
    return shared >= _SHARED_HEIGHT * min(high - low, other_high - other_low)


def _covered(source: UprightInstance, target: UprightInstance) -> float:
    """The share of `source` that, from above, has surface of `target` over it."""
    _, middle, top = source.heights_m
    over = target.points[_close_by(target.points, source, above_m=HEADROOM_M)]
    over = over[(over[:, 2] > middle) & (over[:, 2] < top + HEADROOM_M)]
    if len(over) == 0:
        return 0.0
    distances = source.plan.query(over[:, :2], distance_upper_bound=TOUCH_M)
    rows = distances[1][np.isfinite(distances[0])]
    cells = np.unique(np.floor(source.sample[:, :2] / TOUCH_M).astype(np.int64), axis=0)
    covered_cells = np.unique(np.floor(source.sample[rows, :2] / TOUCH_M).astype(np.int64), axis=0)
    return len(covered_cells) / len(cells)


def _surrounded(source: UprightInstance, target: UprightInstance) -> float:
    """In which share of the directions round `source` there is surface of `target` at its height."""
    low, _, high = source.heights_m
    around = target.points[(target.points[:, 2] >= low) & (target.points[:, 2] <= high)]
    toward = around[:, :2] - source.box.center[:2]
    angle = np.arctan2(toward[:, 1], toward[:, 0])
    return len(np.unique(np.floor((angle / (2 * np.pi) + 0.5) * _SECTORS) % _SECTORS)) / _SECTORS


def _close_by(points: Float64Array, source: UprightInstance, above_m: float = 0.0) -> BoolArray:
    """Which points (N, 3) lie in the bounds of `source`, a little larger."""
    low, high = source.bounds - TOUCH_M, source.bounds + TOUCH_M
    return np.asarray(((points >= low[0]) & (points <= high[1] + [0, 0, above_m])).all(axis=1))
