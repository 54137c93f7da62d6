"""Depth reprojection test of relative poses: how much of one frame's depth lies on that of another."""

from __future__ import annotations

import numpy as np

from razer.arrays import Float64Array
from razer.frame import Frame
from razer.geometry import back_project, project, transform_points

_MIN_PAIRS = 4
_FITS = 0.5  # of frames that overlap well and are moved rightly
_CLEARLY_WORSE = 0.6
_STEP = 6
_TOLERANCE = 0.04


def overlapping_only(agreements: Float64Array) -> Float64Array:
    """Of agreements (P, H) of P pairs under H hypotheses, those of the pairs that overlap well under any of them."""
    return agreements[agreements.max(axis=1, initial=0) > _FITS]


def clearly_better(agreements: Float64Array) -> int:
    """Which hypothesis makes depth agree clearly better than the first over overlapping pairs (P, H); 0 = none, or
    the pairs are few."""
    if len(agreements) < _MIN_PAIRS:
        return 0
    means = agreements.mean(axis=0)
    best = int(means.argmax())
    return best if means[best] > _FITS and means[0] < _CLEARLY_WORSE * means[best] else 0


def depth_agreement(a: Frame, b: Frame, b_from_a: Float64Array, depth_factor: float = 1.0) -> float:
    """Share of a's readings that b_from_a moves to within 4 % of what b reads at the same pixel; 0 where a has none.

    Args:
        a: the frame whose depth is moved.
        b: the frame whose depth it is compared with.
        b_from_a: (4, 4) rigid, metres.
        depth_factor: by which the depth of both is multiplied.
    """
    v, u = _STEP * np.array(np.nonzero(a.depth[::_STEP, ::_STEP]))
    points = back_project(u, v, a.depth[v, u] * depth_factor, a.intrinsics.matrix)
    x, y, z = project(transform_points(b_from_a, points), b.intrinsics.matrix)
    inside = (x > -0.5) & (x < b.intrinsics.width - 0.5) & (y > -0.5) & (y < b.intrinsics.height - 0.5)
    column, row = np.rint(x[inside]).astype(int), np.rint(y[inside]).astype(int)
    depth_b = b.depth[row, column] * depth_factor
    return float(np.sum(np.abs(depth_b - z[inside]) < _TOLERANCE * z[inside]) / max(len(u), 1))
