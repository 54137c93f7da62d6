"""Background filter for clusters of one mask: the wall behind the bars of a chair is no part of it."""

from __future__ import annotations

import numpy as np

from razer.arrays import Float32Array, Float64Array
from razer.boxes.oriented_box import OrientedBox, PointMoments

# Parts of one thing that something nearer hides in between lie within about its own size; half of that is asked, as
# a part seen of it is smaller than the whole.
SHARE_OF_SIZE = 0.5
EDGE_PERCENT = 10  # of a cluster's readings may lie beyond the depths at which it is taken to begin and to end


def background_limit_m(depths_m: Float32Array, points: Float64Array, min_gap_m: float) -> float:
    """The depth from which readings of a mask are background: farther behind the end of its largest cluster, of depths
    (P,) metres and world points (N, 3) metres, than half that one's size, and than `min_gap_m`."""
    size_m = OrientedBox.around(points, PointMoments.of(points).axes).extent.max()
    return float(np.percentile(depths_m, 100 - EDGE_PERCENT) + max(min_gap_m, SHARE_OF_SIZE * size_m))
