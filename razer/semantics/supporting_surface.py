"""Supporting surface: which instance's level surface lies around the foot of a thing, and so carries it.

The contact itself is never seen. What carries a thing shows as a rim of level surface round its foot, at the height of
its lowest points; of several, the one that shows most of that rim carries it, and nothing else does.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from scipy.spatial import KDTree

from razer.arrays import Float64Array, Int64Array
from razer.semantics.doubles import is_double
from razer.semantics.upright_instance import UprightInstance

NOBODY = 0

BESIDE_M = 0.1  # how far round a foot its support is looked for
# Support lies this much lower and higher than the lowest points of what it carries: voxels round edges, masks shrink.
_BELOW_M, _ABOVE_M = 0.07, 0.04
_CELL_M = 0.04
_MIN_CELLS = 3
_MIN_SHARE = 0.25  # of the rim: the rest is what else stands there
_MARGIN_M = 0.08  # how far beyond the outline of a support the middle of a foot may lie
# What is higher than this carries nothing at its own lowest points: a strip of floor that bears a chair's label does
# not make the chair carry what stands beside it.
_FLAT_M, _RAISED_M = 0.1, 0.05


class SupportingSurfaces:
    """The level surface of all instances, with `background` (of id NOBODY) for what belongs to none."""

    def __init__(self, instances: Sequence[UprightInstance], background: UprightInstance | None = None) -> None:
        carriers = [i for i in (*instances, background) if i is not None and not (i.stuff and i.is_wall)]
        self._by_id = {carrier.id: carrier for carrier in carriers}
        self._points = np.concatenate([np.zeros((0, 3)), *(carrier.level for carrier in carriers)])
        self._owners = np.repeat([c.id for c in carriers] or [0], [len(c.level) for c in carriers] or [0])
        self._tree = KDTree(self._points)

    def supporter(self, source: UprightInstance) -> int | None:
        """The id of what carries `source`; None where no level surface lies round its foot."""
        rim, owners = self._rim(source)
        cells = np.unique(np.column_stack([np.floor(rim[:, :2] / _CELL_M).astype(np.int64), owners]), axis=0)
        ids, counts = np.unique(cells[:, 2], return_counts=True)
        for row in np.argsort(-counts, kind="stable"):
            is_large = counts[row] >= max(_MIN_CELLS, _MIN_SHARE * counts.sum())
            carrier = self._by_id[int(ids[row])]
            if is_large and _carries(carrier, source, rim[owners == ids[row]]):
                return carrier.id
        return None

    def _rim(self, source: UprightInstance) -> tuple[Float64Array, Int64Array]:
        """The level surface (N, 3) round the foot of `source` that is not its own, and whose it is (N,)."""
        near = self._tree.query_ball_point(source.foot, float(np.hypot(BESIDE_M, _BELOW_M)))
        rows = np.unique(np.concatenate([np.zeros(0, np.int64), *(np.array(r, np.int64) for r in near)]))
        rows = rows[self._owners[rows] != source.id]
        points = self._points[rows]
        above = points[:, 2] - source.heights_m[0]
        beside = KDTree(source.foot[:, :2]).query(points[:, :2])[0] <= BESIDE_M
        kept = (above >= -_BELOW_M) & (above <= _ABOVE_M) & beside
        return points[kept], self._owners[rows][kept]


def _carries(carrier: UprightInstance, source: UprightInstance, rim: Float64Array) -> bool:
    """Whether `carrier` has its level surface above its own lowest points, and spans the middle of the foot."""
    if carrier.id == NOBODY:
        return True
    low, _, high = carrier.heights_m
    is_raised = carrier.stuff or high - low <= _FLAT_M or float(np.median(rim[:, 2])) >= low + _RAISED_M
    middle = (source.foot[:, :2].min(axis=0) + source.foot[:, :2].max(axis=0)) / 2
    return is_raised and carrier.spans(middle, _MARGIN_M) and not is_double(carrier, source)
