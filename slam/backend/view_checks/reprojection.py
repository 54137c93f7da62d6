"""Reprojection of the sparse readings of one view into another."""

from __future__ import annotations

import numpy as np

from razer.arrays import Float64Array, IndexArray
from slam.frontend.keyframes import View

MIN_DEPTH_M = 0.1  # nearer points, and those behind the camera, are not projected


def reprojected(view: View, other: View, other_from_view: Float64Array) -> tuple[IndexArray, IndexArray, Float64Array]:
    """The readings of a view that fall on another's image: their pixels (M,) in the one and in the other, rows one
    after the other, and their depths (M,) before the other's camera, metres.

    Args:
        view: the view whose readings they are.
        other: the view they are projected into.
        other_from_view: (4, 4) the motion between them.
    """
    pixel = np.flatnonzero(view.sparse_depth)
    points = _points(view, pixel) @ other_from_view[:3, :3].T + other_from_view[:3, 3]
    in_front, k = points[:, 2] > MIN_DEPTH_M, other.sparse_intrinsics
    pixel, points = pixel[in_front], points[in_front]
    column, row = np.rint(points[:, :2] / points[:, 2:] * (k.fx, k.fy) + (k.cx, k.cy)).T.astype(int)
    inside = (column >= 0) & (column < k.width) & (row >= 0) & (row < k.height)
    return pixel[inside], (row * k.width + column)[inside], points[inside, 2]


def _points(view: View, pixel: IndexArray) -> Float64Array:
    k, z = view.sparse_intrinsics, view.sparse_depth.ravel()[pixel].astype(np.float64)
    return np.column_stack([(pixel % k.width - k.cx) / k.fx * z, (pixel // k.width - k.cy) / k.fy * z, z])
