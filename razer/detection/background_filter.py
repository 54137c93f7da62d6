"""Background filter for clusters of one mask: the wall behind the bars of a chair is no part of it."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from razer.arrays import Float32Array
from razer.boxes.oriented_box import OrientedBox

# Parts of one thing that something nearer hides in between lie within about its own size; half of that is asked, as
# a part seen of it is smaller than the whole.
SHARE_OF_SIZE = 0.5
EDGE_PERCENT = 10  # of a cluster's readings may lie beyond the depths at which it is taken to begin and to end


def background_clusters(depths_m: Sequence[Float32Array], boxes: Sequence[OrientedBox], min_gap_m: float) -> list[int]:
    """Which clusters of one mask are background: those that begin farther behind the end of the largest cluster than
    half its size, and than `min_gap_m`. depths_m are those of each cluster's readings, metres."""
    largest = max(range(len(boxes)), key=lambda i: len(depths_m[i]))
    far_m = np.percentile(depths_m[largest], 100 - EDGE_PERCENT)
    gap_m = max(min_gap_m, SHARE_OF_SIZE * float(boxes[largest].extent.max()))
    return [i for i, depth_m in enumerate(depths_m) if np.percentile(depth_m, EDGE_PERCENT) > far_m + gap_m]
