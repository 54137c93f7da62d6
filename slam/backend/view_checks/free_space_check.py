"""Free-space consistency check of two views: nothing may stand where the other looked through.

Places that look alike agree in most of what two views share, since only what agrees made them look alike. What gives
them away is the rest: a door that hangs in the air in front of the corridor's end. So all of the depth is compared,
the far part too, which registration leaves out for its noise.
"""

from __future__ import annotations

from functools import lru_cache

import cv2
import numpy as np

from razer.arrays import BoolArray, Float32Array, Float64Array, IndexArray
from razer.geometry import inverse
from slam.backend.view_checks.reprojection import KEPT_VIEWS, flat_depth, reprojected, smear_pixels
from slam.config import FreeSpaceSettings
from slam.frontend.keyframes import View
from slam.frontend.sparse_readings import SparseReadings

MIN_SHARED = 50  # readings; with fewer in common there is no answer


def contradiction(
    target: View, source: View, target_from_source: Float64Array, settings: FreeSpaceSettings, drift_m: float = 0.0
) -> float:
    """Share of the readings of one view, of those that fall on readings of the other, that stand where the other saw
    through; the greater of both ways.

    Args:
        target: one view.
        source: the other.
        target_from_source: (4, 4) the motion to be checked.
        settings: how far in front of a reading something must stand to contradict it.
        drift_m: and by how much more, as the motion may be that far off.
    """
    return max(
        _standing_share(source, target, target_from_source, settings, drift_m),
        _standing_share(target, source, inverse(target_from_source), settings, drift_m),
    )


def _standing_share(
    view: View, other: View, other_from_view: Float64Array, settings: FreeSpaceSettings, drift_m: float
) -> float:
    pixel, is_standing = standing_readings(view, other, other_from_view, settings, drift_m)
    return 0.0 if len(pixel) < MIN_SHARED else float(is_standing.mean())


def standing_readings(
    view: View, other: View, other_from_view: Float64Array, settings: FreeSpaceSettings, drift_m: float = 0.0
) -> tuple[IndexArray, BoolArray]:
    """The pixels (M,) of a view's sparse readings that fall on readings of another, rows one after the other, and which
    of them (M,) stand where the other saw through.

    Args:
        view: the view whose readings they are.
        other: the view they are held against.
        other_from_view: (4, 4) the motion between them.
        settings: how far in front of a reading something must stand.
        drift_m: and by how much more, as the motion may be that far off.
    """
    here, pixel, z = reprojected(view, other, other_from_view)
    # At the nearest of a pixel's neighbours, so that edges contradict nothing; holes, which are 0, do not either.
    read = np.flatnonzero(flat_depth(other.sparse)[pixel] > 0)
    here, z, nearest = here[read], z[read], _nearest_about(other.sparse, 1 + smear_pixels(view, other))[pixel[read]]
    is_standing: BoolArray = z < nearest - (settings.margin_m + settings.margin_per_m * nearest + drift_m)
    return here, is_standing


@lru_cache(maxsize=KEPT_VIEWS)
def _nearest_about(readings: SparseReadings, radius: int) -> Float32Array:
    """The nearest (h * w,) of the readings so many pixels about each: holes, which are 0, where there are any."""
    square = np.ones((2 * radius + 1,) * 2, np.uint8)
    nearest: Float32Array = cv2.erode(flat_depth(readings).reshape(readings.depth.shape), square).ravel()
    return nearest
