"""Supporting surface: which instance's level surface lies round the foot of a thing, and so carries it.

The contact itself is never seen. What carries a thing shows as a rim of level surface round its foot, at the height of
its lowest points; of several, the one that shows most of that rim carries it, and nothing else does.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.spatial import KDTree

from razer.arrays import Float64Array, Int64Array
from razer.semantics.doubles import is_double
from razer.semantics.upright_instance import UprightInstance

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
_SEEN_BENEATH = 0.3


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


class SupportingSurfaces:
    """The level surface of all instances, with `background` (of id NOBODY) for what belongs to none."""

    def __init__(self, instances: Sequence[UprightInstance], background: UprightInstance | None = None) -> None:
        carriers = [i for i in (*instances, background) if i is not None and not (i.stuff and i.is_wall)]
        self._by_id = {carrier.id: carrier for carrier in carriers}
        thinned = [_one_a_cell(carrier.level) for carrier in carriers]
        self._points = np.concatenate([np.zeros((0, 3)), *thinned])
        self._owners = np.repeat(np.array([c.id for c in carriers], np.int64), [len(points) for points in thinned])
        self._tree = KDTree(self._points)

    def supporter(self, source: UprightInstance) -> int | None:
        """The id of what carries `source`; None where no level surface lies round or under its foot."""
        for step in _PASSES:
            if step.is_hidden and source.is_sheet:
                continue
            carrier = self._carrier(source, step)
            if carrier is not None:
                return carrier
        return None

    def _carrier(self, source: UprightInstance, step: _Pass) -> int | None:
        foot = source.foot(step.trim, of_body=step.of_body)
        rim, owners = self._rim(source.id, foot, step)
        ids, counts = _cells_of_owners(rim, owners)
        round_foot = 2 * np.ptp(foot[:, :2], axis=0).sum() * BESIDE_M / _CELL_M**2
        middle = (foot[:, :2].min(axis=0) + foot[:, :2].max(axis=0)) / 2
        # What reaches under the foot comes before what merely lies beside it, however much of that is seen.
        reaches = np.array([i != NOBODY and self._by_id[int(i)].spans(middle, 0.0) for i in ids], np.bool_)
        for row in np.lexsort((-counts, ~reaches)):
            carrier, own = self._by_id[int(ids[row])], rim[owners == ids[row]]
            of_its_kind = bool(source.name) and carrier.name == source.name
            least_round = (_MIN_ROUND_ALIKE if of_its_kind else _MIN_ROUND) * round_foot
            is_large = counts[row] >= max(_MIN_CELLS, _MIN_SHARE * counts.sum(), least_round)
            if is_large and _carries(carrier, source, foot, own):
                is_likely = reaches[row] and not of_its_kind and not _is_seen_beneath(foot, own)
                return carrier.id if is_likely or not step.is_hidden else None
        return None

    def _rim(self, number: int, foot: Float64Array, step: _Pass) -> tuple[Float64Array, Int64Array]:
        """The level surface (N, 3) round a foot that is not its own, and whose it is (N,)."""
        near = self._tree.query_ball_point(foot, float(np.hypot(step.beside_m, max(step.below_m, _ABOVE_M))))
        rows = np.unique(np.concatenate([np.zeros(0, np.int64), *(np.array(r, np.int64) for r in near)]))
        rows = rows[self._owners[rows] != number]
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
        is_beneath = is_beneath and float(foot[:, 2].min()) >= high - _RAISED_M
    return is_beneath and not is_double(carrier, source)


def _is_seen_beneath(foot: Float64Array, rim: Float64Array) -> bool:
    """Whether the support is seen under the foot itself, and not only round it."""
    cells = np.unique(np.floor(foot[:, :2] / _CELL_M).astype(np.int64), axis=0)
    seen = np.unique(np.floor(rim[:, :2] / _CELL_M).astype(np.int64), axis=0)
    both = np.unique(np.concatenate([cells, seen]), axis=0)
    return len(cells) + len(seen) - len(both) > _SEEN_BENEATH * len(cells)
