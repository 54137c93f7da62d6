"""Which instances of two maps of one place are the same thing."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from scipy.optimize import linear_sum_assignment

from razer.arrays import FloatArray, IntArray
from razer.metrics.instances.matching import Overlaps, count_overlaps
from razer.metrics.surface.nearest_vertices import transfer_labels

MAX_DISTANCE_M = 0.05
MIN_IOU = 0.25


class InstancePair(NamedTuple):
    """The ids of one thing in two maps, and the intersection over union of its vertices."""

    a: int
    b: int
    iou: float


def pair_instances(
    vertices_a: FloatArray, ids_a: IntArray, vertices_b: FloatArray, ids_b: IntArray, min_iou: float = MIN_IOU
) -> tuple[InstancePair, ...]:
    """The one-to-one pairs whose overlaps add up to most, each at least min_iou, by increasing id in the first map.

    Both maps lie in one frame: vertices (N, 3), (M, 3) in metres with ids (N,), (M,), 0 for nobody."""
    overlaps = surface_overlaps(vertices_a, ids_a, vertices_b, ids_b)
    iou = np.where(overlaps.iou >= min_iou, overlaps.iou, 0.0)
    rows, columns = linear_sum_assignment(iou, maximize=True)
    return tuple(
        InstancePair(int(overlaps.truth_ids[r]), int(overlaps.predicted_ids[c]), float(iou[r, c]))
        for r, c in zip(rows, columns, strict=True)
        if iou[r, c] > 0
    )


def surface_overlaps(
    vertices_a: FloatArray,
    ids_a: IntArray,
    vertices_b: FloatArray,
    ids_b: IntArray,
    max_distance_m: float = MAX_DISTANCE_M,
) -> Overlaps:
    """What instances share, counted over the vertices of both maps, so that neither is the measure of the other: each
    vertex bears its own id and that of the nearest vertex of the other map within max_distance_m."""
    there = transfer_labels(vertices_b, ids_b, vertices_a, max_distance_m)
    back = transfer_labels(vertices_a, ids_a, vertices_b, max_distance_m)
    own_a, own_b = ids_a.astype(np.int64), ids_b.astype(np.int64)
    return count_overlaps(np.concatenate([own_a, back]), np.concatenate([there, own_b]))
