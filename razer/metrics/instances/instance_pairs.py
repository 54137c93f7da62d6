"""One-to-one instance correspondence between two maps of one place, by optimal assignment on IoU."""

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
    """The ids of one object in two maps, and the intersection over union of its vertices."""

    a: int
    b: int
    iou: float


def pair_instances(
    vertices_a: FloatArray, ids_a: IntArray, vertices_b: FloatArray, ids_b: IntArray, min_iou: float = MIN_IOU
) -> tuple[InstancePair, ...]:
    """The one-to-one pairs whose IoUs add up to most (Hungarian assignment), by increasing id in the first map.

    Args:
        vertices_a: (N, 3), metres; both maps lie in one frame.
        ids_a: (N,), instance ids of these, 0 for none.
        vertices_b: (M, 3), metres.
        ids_b: (M,), instance ids of these, 0 for none.
        min_iou: pairs below this intersection over union are left out.
    """
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
    """Overlaps of instances counted over the vertices of both maps, so that neither is the reference of the other:
    each vertex bears its own id and that of the nearest vertex of the other map.

    Args:
        vertices_a: (N, 3), metres; both maps lie in one frame.
        ids_a: (N,), instance ids of these, 0 for none.
        vertices_b: (M, 3), metres.
        ids_b: (M,), instance ids of these, 0 for none.
        max_distance_m: farther vertices of the other map carry no id.
    """
    b_on_a = transfer_labels(vertices_b, ids_b, vertices_a, max_distance_m)
    a_on_b = transfer_labels(vertices_a, ids_a, vertices_b, max_distance_m)
    own_a, own_b = ids_a.astype(np.int64), ids_b.astype(np.int64)
    return count_overlaps(np.concatenate([own_a, a_on_b]), np.concatenate([b_on_a, own_b]))
