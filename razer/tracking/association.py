"""Data association of detections to tracks: candidates from the R-tree, the cost M = w_v V + w_s S, a gate, and the
Hungarian method in each connected component (RAZER section IV-C, RAZER eq. 8)."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np
from scipy.optimize import linear_sum_assignment
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components

from razer.arrays import Float64Array, IndexArray
from razer.boxes.iou import box_containment, box_iou
from razer.boxes.iou_bounds import iou_bounds, tight_iou_bounds
from razer.boxes.oriented_box import OrientedBox
from razer.boxes.rtree_index import BoxIndex
from razer.config import AssociationSettings
from razer.detection.lifting import Detection
from razer.tracking.embedding_bank import euclidean_distance, same_thing_doubt
from razer.tracking.label_overlap import LabelOverlap
from razer.tracking.similarity_pairs import MAX_GEOMETRY
from razer.tracking.step_result import Candidate
from razer.tracking.stuff import may_be_one
from razer.tracking.track import Track

# Costs above the gate are replaced by this, so that the assignment prefers any allowed pair.
FORBIDDEN = 1e3


def find_candidates(
    detections: Sequence[Detection],
    tracks: Mapping[int, Track],
    index: BoxIndex,
    overlap: LabelOverlap,
    settings: AssociationSettings,
) -> list[tuple[Candidate, ...]]:
    """For each detection the tracks it may belong to, cheapest first.

    Args:
        detections: Those of one frame.
        tracks: Live tracks by id.
        index: R-tree of their boxes.
        overlap: The labels under the detections, and how much of each track the frame shows.
        settings: Weights, gate and distances.
    """
    near = _candidate_pairs(detections, tracks, index, overlap, settings)
    pairs = [(i, t) for i, t in near if may_be_one(detections[i], tracks[t])]
    if not pairs:
        return [()] * len(detections)
    rows, ids = np.array([i for i, _ in pairs]), [t for _, t in pairs]
    paired_ids = sorted(set(ids))
    banks, embeddings = [tracks[t].bank for t in paired_ids], np.stack([d.embedding for d in detections])
    measure = same_thing_doubt if settings.semantic_distance == "calibrated" else euclidean_distance
    semantic = measure(banks, embeddings)[np.searchsorted(paired_ids, ids), rows]
    max_geometry = (settings.gate - settings.weight_semantic * semantic) / max(settings.weight_geometry, 1e-9)
    # What the similarity scale learns from must not depend on the embedding, by which the gate leaves more or less.
    min_overlap = 1 - np.maximum(max_geometry, MAX_GEOMETRY)
    geometry_overlap = _overlaps(detections, tracks, pairs, overlap, min_overlap, settings)
    cost = settings.weight_geometry * (1 - geometry_overlap) + settings.weight_semantic * semantic
    candidates: list[list[Candidate]] = [[] for _ in detections]
    for (i, t), v, s, m in zip(pairs, 1 - geometry_overlap, semantic, cost, strict=True):
        candidates[i].append(Candidate(t, float(v), float(s), float(m)))
    return [tuple(sorted(row, key=lambda c: (c.cost, c.track_id))) for row in candidates]


def _candidate_pairs(
    detections: Sequence[Detection],
    tracks: Mapping[int, Track],
    index: BoxIndex,
    overlap: LabelOverlap,
    settings: AssociationSettings,
) -> list[tuple[int, int]]:
    """(detection, track) of all that lie close; with 'visible' distance only of those that share cells or a box."""
    pairs = [(i, t) for i, d in enumerate(detections) for t in index.near(d.box, settings.search_margin_m)]
    if settings.geometry_distance != "visible":
        return pairs
    if not pairs:
        return sorted(pair for pair in overlap.shared if pair[1] in tracks)
    boxes, first, second = _boxes_of_pairs(detections, tracks, pairs)
    min_iou = 1 - settings.gate / max(settings.weight_geometry, 1e-9)
    likely = np.flatnonzero(iou_bounds(boxes, settings.box_margin_m, first, second) > min_iou)
    return sorted({pairs[i] for i in likely} | {pair for pair in overlap.shared if pair[1] in tracks})


def _boxes_of_pairs(
    detections: Sequence[Detection], tracks: Mapping[int, Track], pairs: Sequence[tuple[int, int]]
) -> tuple[list[OrientedBox], IndexArray, IndexArray]:
    """The boxes of all detections and of the paired tracks, and the two of each pair as indices of them."""
    ids = sorted({t for _, t in pairs})
    boxes = [d.box for d in detections] + [tracks[t].box for t in ids]
    return boxes, np.array([i for i, _ in pairs]), len(detections) + np.searchsorted(ids, [t for _, t in pairs])


def _overlaps(
    detections: Sequence[Detection],
    tracks: Mapping[int, Track],
    pairs: Sequence[tuple[int, int]],
    overlap: LabelOverlap,
    min_overlap: Float64Array,
    settings: AssociationSettings,
) -> Float64Array:
    """1 - V_ij (P,) of each pair, by the chosen measure; exact where it is more than `min_overlap` (P,)."""
    if settings.geometry_distance == "paper":
        margin_m, measure = 0.0, box_iou
    else:
        margin_m = settings.box_margin_m
        measure = box_iou if settings.geometry_distance == "visible" else box_containment
    boxes, first, second = _boxes_of_pairs(detections, tracks, pairs)
    result = np.zeros(len(pairs))
    if settings.geometry_distance == "visible":
        result[:] = [overlap.visible_iou(i, t) for i, t in pairs]
    # Boxes are compared only where the result can be more than is asked for: it is the dearest step.
    bound = np.ones(len(pairs))
    if settings.geometry_distance == "visible":
        bound = iou_bounds(boxes, margin_m, first, second)
    open_pairs = np.flatnonzero(bound > np.maximum(result, min_overlap))
    if settings.geometry_distance == "visible" and len(open_pairs):
        tighter = tight_iou_bounds(boxes, margin_m, first[open_pairs], second[open_pairs])
        open_pairs = open_pairs[tighter > np.maximum(result, min_overlap)[open_pairs]]
    box_overlap = measure(*([boxes[i].grown(margin_m) for i in of[open_pairs]] for of in (first, second)))
    result[open_pairs] = np.maximum(result[open_pairs], box_overlap)
    return result


def assign(candidates: Sequence[Sequence[Candidate]], gate: float) -> dict[int, int]:
    """The cheapest one-to-one assignment {detection: track id} among pairs that pass the gate.

    Each connected component of the graph of allowed pairs is solved alone (Hungarian method), which changes
    nothing in the result.
    """
    allowed = [(i, c.track_id, c.cost) for i, row in enumerate(candidates) for c in row if c.cost <= gate]
    if not allowed:
        return {}
    ids = sorted({t for _, t, _ in allowed})
    column = {t: j for j, t in enumerate(ids)}
    rows, columns = np.array([i for i, _, _ in allowed]), np.array([column[t] for _, t, _ in allowed])
    n = len(candidates)
    graph = coo_array((np.ones(len(rows)), (rows, n + columns)), shape=(n + len(ids), n + len(ids)))
    component = connected_components(graph, directed=False)[1]
    cost = np.full((n, len(ids)), FORBIDDEN)
    cost[rows, columns] = [c for _, _, c in allowed]
    result = {}
    for group in np.unique(component[rows]):
        members = np.flatnonzero(component[:n] == group)
        targets = np.flatnonzero(component[n:] == group)
        for i, j in zip(*linear_sum_assignment(cost[np.ix_(members, targets)]), strict=True):
            if cost[members[i], targets[j]] < FORBIDDEN:
                result[int(members[i])] = ids[targets[j]]
    return dict(sorted(result.items()))
