"""Free-space consistency check of two views: nothing may stand where the other looked through.

Places that look alike agree in most of what two views share, since only what agrees made them look alike. What gives
them away is the rest: a door that hangs in the air in front of the corridor's end. So all of the depth is compared,
the far part too, which registration leaves out for its noise.
"""

from __future__ import annotations

import cv2
import numpy as np

from razer.arrays import Float32Array, Float64Array
from razer.frame import Intrinsics
from razer.geometry import inverse
from slam.config import FreeSpaceSettings
from slam.frontend.keyframes import View

MIN_SHARED = 50  # readings; with fewer in common there is no answer
MIN_DEPTH_M = 0.1  # nearer points, and those behind the camera, are not projected


def contradiction(target: View, source: View, target_from_source: Float64Array, settings: FreeSpaceSettings) -> float:
    """Share of the readings of one view, of those that fall on readings of the other, that stand where the other saw
    through; the greater of both ways.

    Args:
        target: one view.
        source: the other.
        target_from_source: (4, 4) the motion to be checked.
        settings: how far in front of a reading something must stand to contradict it.
    """
    return max(
        _standing_share(source, target, target_from_source, settings),
        _standing_share(target, source, inverse(target_from_source), settings),
    )


def _standing_share(view: View, other: View, other_from_view: Float64Array, settings: FreeSpaceSettings) -> float:
    points = _points(view.sparse_depth, view.sparse_intrinsics) @ other_from_view[:3, :3].T + other_from_view[:3, 3]
    k = other.sparse_intrinsics
    points = points[points[:, 2] > MIN_DEPTH_M]
    column, row = np.rint(points[:, :2] / points[:, 2:] * (k.fx, k.fy) + (k.cx, k.cy)).T.astype(int)
    inside = (column >= 0) & (column < k.width) & (row >= 0) & (row < k.height)
    # At the nearest of a pixel's neighbours, so that edges contradict nothing; holes, which are 0, do not either.
    nearest = cv2.erode(other.sparse_depth, np.ones((3, 3), np.uint8))[row[inside], column[inside]]
    read = other.sparse_depth[row[inside], column[inside]] > 0
    if read.sum() < MIN_SHARED:
        return 0.0
    standing = points[inside, 2] < nearest - (settings.margin_m + settings.margin_per_m * nearest)
    return float(standing[read].mean())


def _points(depth: Float32Array, k: Intrinsics) -> Float64Array:
    row, column = np.nonzero(depth)
    z = depth[row, column].astype(np.float64)
    return np.column_stack([(column - k.cx) / k.fx * z, (row - k.cy) / k.fy * z, z])
