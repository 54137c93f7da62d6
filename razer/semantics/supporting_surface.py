"""Supporting surface: which instance's level surface lies round the foot of a thing, and so carries it.

The contact itself is never seen. What carries a thing shows as a rim of level surface round its foot, at the height of
its lowest points; of several, the one that shows most of that rim carries it, and nothing else does.
"""

from __future__ import annotations

from collections.abc import Collection, Sequence
from dataclasses import dataclass

import numpy as np
from scipy.spatial import ConvexHull, KDTree, QhullError

from razer.arrays import Float64Array, Int64Array
from razer.semantics.doubles import is_double
from razer.semantics.hidden_foot import is_hidden_below
from razer.semantics.upright_instance import UprightInstance
from razer.semantics.wall_contact import AGAINST_M, WallPlane, lies_flat, wall_plane

NOBODY = 0

BESIDE_M = 0.1  # how far round a foot its support is looked for
_ABOVE_M = 0.04  # support is this much higher than the foot at most: voxels round edges, masks shrink
_CELL_M = 0.04
_MIN_CELLS = 2
_MIN_SHARE = 0.25  # of the rim: the rest is what else stands there
# Of the cells that a rim all the way round would have; more where both are of one class and may be pieces of one thing.
_MIN_ROUND, _MIN_ROUND_ALIKE = 0.03, 0.3
# How far beyond what is seen of a support the middle of a foot may lie, besides half of the foot, which hides it.
_MARGIN_M, _MAX_MARGIN_M = 0.08, 0.35
# What is higher than this carries nothing at its own lowest points: a strip of floor that bears a chair's label does
# not make the chair carry what stands beside it.
_FLAT_M, _RAISED_M = 0.1, 0.05
# What belongs to nobody is part of a thing that shows this much as much of the same surface near by.
_GOES_ON = 0.2
_REST_M = 0.03  # what lies flat on a wall, or on its like, is this close to what carries it: one and a half voxels
_BEYOND_M = 2.0  # a floor goes on behind furniture, this far beyond what is seen of it at most
_HIDDEN_M = 0.6  # a thing of which more than this is hidden below may be anywhere


@dataclass(frozen=True, slots=True)
class _Pass:
    """Where the foot is taken to end, as a share of the surface below it, or of the body alone; and how far below and
    beside that support may lie."""

    trim: float
    below_m: float
    beside_m: float = BESIDE_M
    of_body: bool = False
    is_hidden: bool = False


# Borders of masks leave some of a table's label on its cups, and legs are a small share of a chair: the lowest points
# are believed only if nothing is found under the others. Last, the lower part of the thing may be hidden: then nothing
# of the support may be seen beneath it, as it would be under a cupboard on a wall.
_PASSES = (
    _Pass(0.02, 0.045, of_body=True),
    _Pass(0.02, 0.045),
    _Pass(0.005, 0.045),
    _Pass(0.001, 0.07),
    _Pass(0.001, 0.3, 0.3, is_hidden=True),
)
_WIDE = _Pass(0.02, 0.045, 0.3)


@dataclass(frozen=True, slots=True)
class _Standing:
    """A thing, the walls close behind it, whether it lies flat on one, and the ids of what cannot carry it."""

    source: UprightInstance
    walls: Sequence[WallPlane]
    is_flat: bool
    without: Collection[int]


class SupportingSurfaces:
    """The level surface of all instances, with `background` (of id NOBODY) for what belongs to none."""

    def __init__(self, instances: Sequence[UprightInstance], background: UprightInstance | None = None) -> None:
        self._all = [i for i in (*instances, background) if i is not None]
        self._walls = [i for i in self._all if i.id == NOBODY or i.is_wall]
        carriers = [i for i in self._all if not (i.stuff and i.is_wall)]
        self._by_id = {carrier.id: carrier for carrier in carriers}
        thinned = [_one_a_cell(carrier.level) for carrier in carriers]
        self._points = np.concatenate([np.zeros((0, 3)), *thinned])
        self._owners = np.repeat(np.array([c.id for c in carriers], np.int64), [len(points) for points in thinned])
        self._tree = KDTree(self._points)

    def supporter(self, source: UprightInstance, without: Collection[int] = ()) -> int | None:
        """The id of what carries `source`; None where no level surface lies round or under its foot.

        Args:
            source: whose support is sought.
            without: ids of what cannot carry it.
        """
        standing = self._standing(source, without)
        is_on_nobody = False
        for step in _PASSES:
            if step.is_hidden and is_on_nobody:
                return NOBODY
            foot = source.foot(step.trim, of_body=step.of_body)
            carrier = self._carrier(standing, foot, step)
            if carrier == NOBODY:
                is_on_nobody, carrier = True, self._owner_of_level(standing, foot)
            if carrier is not None:
                return carrier
        return self._hidden_floor(standing)

    def _standing(self, source: UprightInstance, without: Collection[int]) -> _Standing:
        near = [wall for wall in self._walls if wall.id != source.id and _may_touch(source, wall)]
        planes = [plane for wall in near if (plane := wall_plane(source, wall)) is not None and plane.is_behind(source)]
        return _Standing(source, planes, any(lies_flat(source, plane) for plane in planes), {*without, source.id})

    def _carrier(self, standing: _Standing, foot: Float64Array, step: _Pass) -> int | None:
        source = standing.source
        rim, owners = self._rim(standing.without, foot, step)
        ids, counts = _cells_of_owners(rim, owners)
        round_foot = 2 * np.ptp(foot[:, :2], axis=0).sum() * BESIDE_M / _CELL_M**2
        middle = _middle(foot)
        # What reaches under the foot comes before what merely lies beside it, however much of that is seen.
        reaches = np.array([i != NOBODY and self._by_id[int(i)].spans(middle, 0.0) for i in ids], np.bool_)
        for row in np.lexsort((-counts, ~reaches)):
            carrier, own = self._by_id[int(ids[row])], rim[owners == ids[row]]
            of_its_kind = bool(source.name) and carrier.name == source.name
            least_round = (_MIN_ROUND_ALIKE if of_its_kind else _MIN_ROUND) * round_foot
            is_large = counts[row] >= max(_MIN_CELLS, _MIN_SHARE * counts.sum(), least_round)
            if is_large and self._may_carry(carrier, standing, foot, own):
                is_likely = (
                    reaches[row] and not of_its_kind and self._is_hidden(standing, foot, float(np.median(own[:, 2])))
                )
                return carrier.id if not step.is_hidden or is_likely else None
        return None

    def _may_carry(self, carrier: UprightInstance, standing: _Standing, foot: Float64Array, rim: Float64Array) -> bool:
        if standing.is_flat and not carrier.stuff and not _is_edge_on(standing.source, carrier):
            return False
        return _carries(carrier, standing.source, foot, rim)

    def _owner_of_level(self, standing: _Standing, foot: Float64Array) -> int | None:
        """Whose level surface goes on, at the same height, where nobody's lies round the foot: of things the one that
        shows most of it near by, else the floor of the room."""
        rim, owners = self._rim(standing.without, foot, _WIDE)
        ids, counts = _cells_of_owners(rim, owners)
        least = max(_MIN_CELLS, _GOES_ON * counts[ids == NOBODY].sum())
        for row in np.argsort(-counts):
            carrier, own = self._by_id[int(ids[row])], rim[owners == ids[row]]
            if carrier.id != NOBODY and counts[row] >= least and self._may_carry(carrier, standing, foot, own):
                return carrier.id
        drop_m = {floor.id: float(foot[:, 2].min()) - floor_m for floor, floor_m in self._floors(foot)}
        return next((number for number in drop_m if abs(drop_m[number]) <= _ABOVE_M), None)

    def _hidden_floor(self, standing: _Standing) -> int | None:
        """The floor under a thing of which nothing is seen near its foot."""
        foot = standing.source.foot(_PASSES[-1].trim)
        for floor, floor_m in self._floors(foot):
            is_below = 0 <= foot[:, 2].min() - floor_m <= _HIDDEN_M
            if is_below and self._is_hidden(standing, foot, floor_m):
                return floor.id
        return None

    def _floors(self, foot: Float64Array) -> list[tuple[UprightInstance, float]]:
        """The floors that may go on to below a foot, and their heights."""
        stuff = (carrier for carrier in self._by_id.values() if carrier.stuff and len(carrier.level))
        near = (floor for floor in stuff if floor.spans(_middle(foot), _BEYOND_M))
        return [(floor, float(np.median(floor.level[:, 2]))) for floor in near]

    def _is_hidden(self, standing: _Standing, foot: Float64Array, support_m: float) -> bool:
        others = (other for other in self._all if other.id != standing.source.id)
        return is_hidden_below(foot, support_m, others, standing.walls)

    def _rim(self, without: Collection[int], foot: Float64Array, step: _Pass) -> tuple[Float64Array, Int64Array]:
        """The level surface (N, 3) round a foot that may carry it, and whose it is (N,)."""
        near = self._tree.query_ball_point(foot, float(np.hypot(step.beside_m, max(step.below_m, _ABOVE_M))))
        rows = np.unique(np.concatenate([np.zeros(0, np.int64), *(np.array(r, np.int64) for r in near)]))
        rows = rows[~np.isin(self._owners[rows], list(without))]
        points = self._points[rows]
        above = points[:, 2] - foot[:, 2].min()
        beside = KDTree(foot[:, :2]).query(points[:, :2])[0] <= step.beside_m
        kept = (above >= -step.below_m) & (above <= _ABOVE_M) & beside
        return points[kept], self._owners[rows][kept]


def _one_a_cell(points: Float64Array) -> Float64Array:
    cells = np.floor(points / (_CELL_M / 2)).astype(np.int64)
    return points[np.unique(cells, axis=0, return_index=True)[1]]


def _cells_of_owners(rim: Float64Array, owners: Int64Array) -> tuple[Int64Array, Int64Array]:
    """Ids, and in how many cells of the ground plan each has surface."""
    cells = np.unique(np.column_stack([np.floor(rim[:, :2] / _CELL_M).astype(np.int64), owners]), axis=0)
    ids, counts = np.unique(cells[:, 2], return_counts=True)
    return ids, counts


def _carries(carrier: UprightInstance, source: UprightInstance, foot: Float64Array, rim: Float64Array) -> bool:
    """Whether `carrier` has its level surface above its own lowest points, and reaches under the foot."""
    if carrier.id == NOBODY:
        return True
    low, high = float(carrier.bounds[0, 2]), carrier.heights_m[2]
    is_raised = carrier.stuff or high - low <= _FLAT_M or float(np.median(rim[:, 2])) >= low + _RAISED_M
    foot_low, foot_high = foot[:, :2].min(axis=0), foot[:, :2].max(axis=0)
    margin_m = min(_MARGIN_M + float((foot_high - foot_low).max()) / 2, _MAX_MARGIN_M)
    is_beneath = is_raised and carrier.spans((foot_low + foot_high) / 2, margin_m)
    if carrier.name == source.name != "":
        is_beneath = is_beneath and float(foot[:, 2].min()) >= high - _RAISED_M and _are_touching(carrier, source)
    return is_beneath and not is_double(carrier, source)


def _are_touching(one: UprightInstance, other: UprightInstance) -> bool:
    """Whether a stack has no gap, as pieces of one thing do whose middle was not mapped."""
    return bool(one.coarse_tree.query(other.sample)[0].min() <= _REST_M)


def _may_touch(source: UprightInstance, wall: UprightInstance) -> bool:
    low, high = wall.bounds[0] - AGAINST_M, wall.bounds[1] + AGAINST_M
    return bool((source.bounds[0] <= high).all() and (source.bounds[1] >= low).all())


def _is_edge_on(source: UprightInstance, carrier: UprightInstance) -> bool:
    """Whether the lower edge of a sheet rests on a thing, whose level surface then reaches right under it."""
    if carrier.id == NOBODY:
        return False
    edge = source.foot(_PASSES[0].trim, of_body=True)
    at_edge = np.abs(carrier.level[:, 2] - edge[:, 2].min()) <= _REST_M
    return _encloses(carrier.level[at_edge, :2], _middle(edge))


def _middle(foot: Float64Array) -> Float64Array:
    return np.asarray((foot[:, :2].min(axis=0) + foot[:, :2].max(axis=0)) / 2)


def _encloses(points: Float64Array, position: Float64Array) -> bool:
    """Whether the convex outline of points (N, 2) holds a position."""
    try:
        outline = ConvexHull(points).equations
    except (QhullError, ValueError):
        return False
    return bool((outline[:, :2] @ position + outline[:, 2] <= 0).all())
