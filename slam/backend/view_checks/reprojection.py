"""Reprojection of the sparse readings of one view into another, and how far off they may lie."""

from __future__ import annotations

import numpy as np

from razer.arrays import Float64Array, IndexArray
from slam.frontend.keyframes import View
from slam.frontend.sparse_readings import pixel_rays
from slam.frontend.view_registration import EXPOSURE_GAP_S

MIN_DEPTH_M = 0.1  # nearer points, and those behind the camera, are not projected


def reprojected(view: View, other: View, other_from_view: Float64Array) -> tuple[IndexArray, IndexArray, Float64Array]:
    """The readings of a view that fall on another's image: their pixels (M,) in the one and in the other, rows one
    after the other, and their depths (M,) before the other's camera, metres.

    Args:
        view: the view whose readings they are.
        other: the view they are projected into.
        other_from_view: (4, 4) the motion between them.
    """
    pixel, (x, y, z) = _points(view, other_from_view)
    k = other.sparse_intrinsics
    column, row = np.rint(x / z * k.fx + k.cx), np.rint(y / z * k.fy + k.cy)
    inside = np.flatnonzero((column >= 0) & (column < k.width) & (row >= 0) & (row < k.height))
    there = row[inside] * k.width + column[inside]
    return pixel[inside], there.astype(np.intp), z[inside]


def smear_pixels(view: View, other: View) -> int:
    """How many pixels of the other view's readings may lie between where they are and where they belong, as far as is
    known how the two cameras turned."""
    turning_rad_s = max(float(np.linalg.norm(each.turning_rad_s)) for each in (view, other))
    return int(EXPOSURE_GAP_S * turning_rad_s * other.sparse_intrinsics.fx)


def _points(view: View, other_from_view: Float64Array) -> tuple[IndexArray, tuple[Float64Array, ...]]:
    """The pixels (M,) of readings in front of another camera, and x, y and z (M,) of their points there."""
    pixel = np.flatnonzero(view.sparse_depth > 0)
    depth = view.sparse_depth.ravel()[pixel].astype(np.float64)
    u, v = (each[pixel] for each in pixel_rays(view.sparse_intrinsics))
    rotation, shift = other_from_view[:3, :3].tolist(), other_from_view[:3, 3].tolist()
    # Written out, as products of large and tiny matrices take longer.
    x, y, z = ((r[0] * u + r[1] * v + r[2]) * depth + t for r, t in zip(rotation, shift, strict=True))
    ahead = z > MIN_DEPTH_M
    return (pixel, (x, y, z)) if ahead.all() else (pixel[ahead], (x[ahead], y[ahead], z[ahead]))
