"""Hidden foot: whether the column below what is seen of a thing is hidden, so that the thing may reach down there.

Free space decides: where a floor, a wall or anything else is seen straight below the lowest points, the thing ends
above; where nothing is seen, it hides that itself, or something before it does.
"""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np

from razer.arrays import Float64Array, Int64Array
from razer.semantics.upright_instance import UprightInstance
from razer.semantics.wall_contact import WallPlane

_CELL_M = 0.04
_CLEAR_M = 0.04  # surface this close to the foot or to the support is part of these
_SEEN = 0.3  # share of the column


def is_hidden_below(
    foot: Float64Array, support_m: float, others: Iterable[UprightInstance], walls: Iterable[WallPlane]
) -> bool:
    """Whether too little is seen between a foot and the height of its support for the thing to end there.

    Args:
        foot: the lowest points (N, 3) that are seen.
        support_m: the height of the support, metres.
        others: all other instances, and the surface that belongs to none.
        walls: the planes that the thing stands close to.
    """
    low, high = support_m + _CLEAR_M, float(foot[:, 2].min()) - _CLEAR_M
    if high - low < _CELL_M:
        return True
    under = _cells(foot[:, :2])
    seen = _cells(np.concatenate([np.zeros((0, 2)), *(_below(foot, low - 2 * _CLEAR_M, high, o) for o in others)]))
    if _shared(under, seen) > _SEEN * len(under):
        return False
    return not any(_shows(wall, foot, low, high) for wall in walls)


def _below(foot: Float64Array, low: float, high: float, other: UprightInstance) -> Float64Array:
    """The surface (N, 2) of another in the box below a foot."""
    corners = np.array([[*foot[:, :2].min(axis=0) - _CELL_M, low], [*foot[:, :2].max(axis=0) + _CELL_M, high]])
    if (other.bounds[0] > corners[1]).any() or (other.bounds[1] < corners[0]).any():
        return np.zeros((0, 2))
    return other.points[((other.points >= corners[0]) & (other.points <= corners[1])).all(axis=1), :2]


def _shows(wall: WallPlane, foot: Float64Array, low: float, high: float) -> bool:
    """Whether the wall is seen straight below."""
    along = wall.along(foot)
    spots = np.column_stack([wall.along(wall.points), wall.points[:, 2]])
    inside = (spots >= [along.min(), low]) & (spots <= [along.max(), high])
    area = max(float(np.ptp(along)), _CELL_M) * (high - low) / _CELL_M**2
    return len(_cells(spots[inside.all(axis=1)])) > _SEEN * area


def _cells(points: Float64Array) -> Int64Array:
    return np.unique(np.floor(points / _CELL_M).astype(np.int64), axis=0)


def _shared(one: Int64Array, other: Int64Array) -> int:
    return len(one) + len(other) - len(np.unique(np.concatenate([one, other]), axis=0))
