"""How much of one frame's depth lies on another's when it is moved there: the reprojection test of poses."""

from __future__ import annotations

from collections.abc import Sequence as Ordered

import numpy as np

from razer.frame import Frame
from razer.geometry import Array, back_project, inverse, project, transform_points

FITS = 0.5
"""Least agreement of frames that overlap well and are moved rightly."""
CLEARLY_WORSE = 0.6
"""How much of the best agreement another may reach at most for the best to be believed."""

_MIN_PAIRS = 4
_STEP = 6
_TOLERANCE = 0.04


def better_factor(pairs: Ordered[tuple[Frame, Frame]], factors: Ordered[float]) -> float | None:
    """Which of the factors on depth makes it agree clearly better over pairs of posed frames than it does as it is;
    None where none does, or pairs are few."""
    if len(pairs) < _MIN_PAIRS or not factors:
        return None
    agreements = [
        float(np.mean([depth_agreement(a, b, inverse(b.pose) @ a.pose, factor) for a, b in pairs]))
        for factor in (1.0, *factors)
    ]
    best = int(np.argmax(agreements))
    clear = agreements[best] > FITS and agreements[0] < CLEARLY_WORSE * agreements[best]
    return factors[best - 1] if clear else None


def depth_agreement(a: Frame, b: Frame, b_from_a: Array, depth_factor: float = 1.0) -> float:
    """Share of a's readings that b_from_a (4, 4) moves to within 4 % of what b reads at the same place, with the
    depth of both times a factor; 0 where a has none."""
    v, u = _STEP * np.array(np.nonzero(a.depth[::_STEP, ::_STEP]))
    points = back_project(u, v, a.depth[v, u] * depth_factor, a.intrinsics.matrix)
    x, y, z = project(transform_points(b_from_a, points), b.intrinsics.matrix)
    inside = (x > -0.5) & (x < b.intrinsics.width - 0.5) & (y > -0.5) & (y < b.intrinsics.height - 0.5)
    column, row = np.rint(x[inside]).astype(int), np.rint(y[inside]).astype(int)
    there = b.depth[row, column] * depth_factor
    return float(np.sum(np.abs(there - z[inside]) < _TOLERANCE * z[inside]) / max(len(u), 1))
