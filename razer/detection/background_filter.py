"""Background filter for clusters of one mask: the wall behind the bars of a chair is no part of it."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from razer.arrays import Float32Array, Float64Array
from razer.boxes.oriented_box import OrientedBox, PointMoments

# Parts of one thing that something nearer hides in between lie within about its own size; half of that is asked, as
# a part seen of it is smaller than the whole.
SHARE_OF_SIZE = 0.5
EDGE_PERCENT = 10  # of a cluster's readings may lie beyond the depths at which it is taken to begin and to end
# The thing is the nearest cluster of its mask that is no splinter: one with this share of the largest one's readings.
# Between the bars of a chair there may be more wall than chair.
SHARE_OF_LARGEST = 0.25


def background_limit_m(depths_m: Sequence[Float32Array], points: Sequence[Float64Array], min_gap_m: float) -> float:
    """The depth from which readings of a mask are background.

    From the nearest cluster on that is no splinter, a mask goes on as long as the next cluster begins no farther behind
    the end of those before it than `min_gap_m`, and than half of the nearest one's size.

    Args:
        depths_m: Of the readings (P,) of each cluster, metres; one cluster at least.
        points: World points (N, 3) of each, metres.
        min_gap_m: A gap that no part of a thing is behind.
    """
    begins_m, ends_m = (np.array([np.percentile(d, q) for d in depths_m]) for q in (EDGE_PERCENT, 100 - EDGE_PERCENT))
    sizes = np.array([len(d) for d in depths_m])
    whole = np.flatnonzero(sizes >= SHARE_OF_LARGEST * sizes.max())
    nearest = int(whole[begins_m[whole].argmin()])
    box = OrientedBox.around(points[nearest], PointMoments.of(points[nearest]).axes)
    gap_m, end_m = max(min_gap_m, SHARE_OF_SIZE * float(box.extent.max())), ends_m[nearest]
    for i in np.argsort(begins_m, kind="stable"):
        if begins_m[i] <= end_m + gap_m:
            end_m = max(end_m, ends_m[i])
    return float(end_m + gap_m)
