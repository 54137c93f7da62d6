"""Stuff in the map: one surface for each class and connected region. Stuff is not counted, so that nothing but its
class and where it lies tells one piece from another (panoptic segmentation, Kirillov 2019)."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Mapping
from itertools import combinations

import numpy as np
from scipy.spatial import cKDTree

from razer.arrays import Int32Array
from razer.detection.lifting import Detection
from razer.tracking.evidence.pair_counts import Pair
from razer.tracking.track import Track

# Cells so far apart, in edges, still touch: diagonally across one that depth noise left out.
REACH_CELLS = 2.5
MIN_CONTACTS = 8  # cells that touch; fewer may be noise
MIN_SHARED = 8  # cells of a piece that lie on a surface which it then belongs to


def may_be_one(detection: Detection, track: Track) -> bool:
    """Whether a detection may be of a track at all: a thing of a thing, stuff of stuff of its class."""
    if detection.is_stuff != track.is_stuff:
        return False
    return not detection.is_stuff or detection.class_name == track.class_name


def surface_beneath(shared: Mapping[int, int]) -> int | None:
    """The stuff track that a piece belongs to by its cells on tracks it may be one with, {track: cells}: that with most
    of them, the older one of equals."""
    best = min(shared, key=lambda track: (-shared[track], track), default=None)
    return best if best is not None and shared[best] >= MIN_SHARED else None


def meeting_pairs(coordinates: Int32Array, labels: Int32Array, class_of: Mapping[int, str | None]) -> list[Pair]:
    """Pairs (older id, newer id) of stuff tracks of one class whose surfaces meet among the cells of a frame.

    Args:
        coordinates: Lattice coordinates (C, 3) of the cells.
        labels: The track (C,) of each, 0 = nobody.
        class_of: The classes of all stuff tracks in view, by id.
    """
    by_class: dict[str | None, list[int]] = defaultdict(list)
    for track, name in sorted(class_of.items()):
        by_class[name].append(track)
    points = {t: coordinates[labels == t] for tracks in by_class.values() if len(tracks) > 1 for t in tracks}
    return [
        pair for tracks in by_class.values() for pair in combinations(tracks, 2) if _meet(*(points[t] for t in pair))
    ]


def _meet(one: Int32Array, other: Int32Array) -> bool:
    """Whether two sets of cells, (N, 3) and (M, 3), touch."""
    if min(len(one), len(other)) < MIN_CONTACTS:
        return False
    apart, _ = cKDTree(one).query(other, distance_upper_bound=REACH_CELLS)
    return int(np.isfinite(apart).sum()) >= MIN_CONTACTS
