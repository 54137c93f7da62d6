"""Free-space consistency check of two views: nothing may stand where the other looked through.

Places that look alike agree in most of what two views share, since only what agrees made them look alike. What gives
them away is the rest: a door that hangs in the air in front of the corridor's end. So all of the depth is compared,
the far part too, which registration leaves out for its noise.
"""

from __future__ import annotations

import cv2
import numpy as np

from razer.arrays import BoolArray, Float64Array, IndexArray
from razer.geometry import inverse
from slam.backend.view_checks.reprojection import reprojected, smear_pixels
from slam.config import FreeSpaceSettings
from slam.frontend.keyframes import View

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
    neighbors = np.ones((3 + 2 * smear_pixels(view, other),) * 2, np.uint8)
    nearest = cv2.erode(other.sparse_depth.astype(np.float32), neighbors).ravel()[pixel]
    read = other.sparse_depth.ravel()[pixel] > 0
    is_standing: BoolArray = z < nearest - (settings.margin_m + settings.margin_per_m * nearest + drift_m)
    return here[read], is_standing[read]
