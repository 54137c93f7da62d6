"""Detections to tracks: candidates from the R-tree, the cost M = w_v V + w_s S, a gate, and the cheapest
assignment of each connected group (RAZER section IV-C, eq. 8)."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TypeVar

import numpy as np
from scipy.optimize import linear_sum_assignment
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components

from razer.arrays import Float64Array, IndexArray
from razer.boxes.iou import box_containment, box_iou
from razer.boxes.oriented_box import OrientedBox
from razer.boxes.rtree_index import BoxIndex
from razer.config import AssociationSettings
from razer.detection.lifting import Detection
from razer.tracking.embedding_bank import bank_similarity
from razer.tracking.label_overlap import LabelOverlap
from razer.tracking.step_result import Candidate
from razer.tracking.track import Track

Cosines = TypeVar("Cosines", float, Float64Array)

# Costs above the gate are replaced by this, so that the assignment prefers any allowed pair.
FORBIDDEN = 1e3


def find_candidates(
    detections: Sequence[Detection],
    tracks: Mapping[int, Track],
    index: BoxIndex,
    evidence: LabelOverlap,
    settings: AssociationSettings,
    unrelated_cosine: float = 0.0,
) -> list[tuple[Candidate, ...]]:
    """For each detection the tracks it may belong to, cheapest first; for unrelated_cosine see `likeness`."""
    pairs = _candidate_pairs(detections, tracks, index, evidence, settings)
    if not pairs:
        return [()] * len(detections)
    rows, ids = np.array([i for i, _ in pairs]), [t for _, t in pairs]
    known = sorted(set(ids))
    cosines = bank_similarity([tracks[t].bank for t in known], np.stack([d.embedding for d in detections]))
    alike = likeness(cosines[np.searchsorted(known, ids), rows], unrelated_cosine)
    allowed = (settings.gate - settings.weight_semantic * (1 - alike)) / max(settings.weight_geometry, 1e-9)
    overlap = _overlaps(detections, tracks, pairs, evidence, 1 - allowed, settings)
    cost = settings.weight_geometry * (1 - overlap) + settings.weight_semantic * (1 - alike)
    found: list[list[Candidate]] = [[] for _ in detections]
    for (i, t), v, s, m in zip(pairs, 1 - overlap, 1 - alike, cost, strict=True):
        found[i].append(Candidate(t, float(v), float(s), float(m)))
    return [tuple(sorted(row, key=lambda c: (c.cost, c.track_id))) for row in found]


def likeness(cosine: Cosines, unrelated_cosine: float) -> Cosines:
    """The cosine as it were if unlike things were at right angles; in the embedder's space their cosine is
    `unrelated_cosine`, 0.8 among class names in CLIP's, where no two vectors are ever far apart."""
    return (cosine - unrelated_cosine) / (1 - unrelated_cosine)


def _candidate_pairs(
    detections: Sequence[Detection],
    tracks: Mapping[int, Track],
    index: BoxIndex,
    evidence: LabelOverlap,
    settings: AssociationSettings,
) -> list[tuple[int, int]]:
    """(detection, track) for all that lie close; where labels decide, for those that share cells or a box."""
    pairs = [(i, t) for i, d in enumerate(detections) for t in index.near(d.box, settings.search_margin_m)]
    if settings.geometry_distance != "visible" or not pairs:
        return pairs
    ids = sorted({t for _, t in pairs})
    boxes = [d.box for d in detections] + [tracks[t].box for t in ids]
    first = np.array([i for i, _ in pairs])
    second = len(detections) + np.searchsorted(ids, [t for _, t in pairs])
    least = 1 - settings.gate / max(settings.weight_geometry, 1e-9)
    likely = np.flatnonzero(_most_shared(boxes, settings.box_margin_m, first, second) > least)
    return sorted({pairs[i] for i in likely} | {pair for pair in evidence.shared if pair[1] in tracks})


def _overlaps(
    detections: Sequence[Detection],
    tracks: Mapping[int, Track],
    pairs: Sequence[tuple[int, int]],
    evidence: LabelOverlap,
    needed: Float64Array,
    settings: AssociationSettings,
) -> Float64Array:
    """1 - V_ij (P,) of each pair, by the chosen measure; `needed` (P,) is what it takes to pass the gate."""
    ids = sorted({t for _, t in pairs})
    if settings.geometry_distance == "paper":
        margin_m, measure = 0.0, box_iou
    else:
        margin_m = settings.box_margin_m
        measure = box_iou if settings.geometry_distance == "visible" else box_containment
    boxes = [d.box for d in detections] + [tracks[t].box for t in ids]
    first = np.array([i for i, _ in pairs])
    second = len(detections) + np.searchsorted(ids, [t for _, t in pairs])
    seen = np.zeros(len(pairs))
    if settings.geometry_distance == "visible":
        seen[:] = [evidence.visible_iou(i, t) for i, t in pairs]
    # Boxes are compared only where that can change who passes the gate: it is the dearest step.
    bound = np.ones(len(pairs))
    if settings.geometry_distance == "visible":
        bound = _most_shared(boxes, margin_m, first, second)
    worth = np.flatnonzero(bound > np.maximum(seen, needed))
    if settings.geometry_distance == "visible" and len(worth):
        closer = _most_shared_turned(boxes, margin_m, first[worth], second[worth])
        worth = worth[closer > np.maximum(seen, needed)[worth]]
    shared = measure(*([boxes[i].grown(margin_m) for i in of[worth]] for of in (first, second)))
    seen[worth] = np.maximum(seen[worth], shared)
    return seen


def _most_shared(boxes: Sequence[OrientedBox], margin_m: float, first: IndexArray, second: IndexArray) -> Float64Array:
    """An upper bound (P,) of the IoU of pairs of boxes, grown by a margin: they share at most what their bounds along
    the world's axes share."""
    center, rotation, half = _stacked(boxes, margin_m)
    reach = _reach(rotation, half)
    low, high = center - reach, center + reach
    overlap = np.minimum(high[first], high[second]) - np.maximum(low[first], low[second])
    return _iou_at_most(overlap, half[first], half[second])


def _most_shared_turned(
    boxes: Sequence[OrientedBox], margin_m: float, first: IndexArray, second: IndexArray
) -> Float64Array:
    """The same from bounds along the axes of either box, which is closer and takes longer."""
    center, rotation, half = _stacked(boxes, margin_m)
    bounds = []
    for one, other in ((first, second), (second, first)):
        axes = rotation[one].transpose(0, 2, 1)
        away = (axes @ (center[other] - center[one])[..., None])[..., 0]
        reach = _reach(axes @ rotation[other], half[other])
        overlap = np.minimum(half[one], away + reach) - np.maximum(-half[one], away - reach)
        bounds.append(_iou_at_most(overlap, half[one], half[other]))
    return np.minimum(*bounds)


def _stacked(boxes: Sequence[OrientedBox], margin_m: float) -> tuple[Float64Array, Float64Array, Float64Array]:
    """Centres (N, 3), rotations (N, 3, 3) and half edges (N, 3) of boxes grown by a margin."""
    center, rotation, extent = (
        np.concatenate([getattr(box, part) for box in boxes]).reshape(len(boxes), -1, 3)
        for part in ("center", "rotation", "extent")
    )
    return center[:, 0], rotation, extent[:, 0] / 2 + margin_m


def _reach(rotation: Float64Array, half: Float64Array) -> Float64Array:
    """How far boxes (P, 3) that are turned by (P, 3, 3) reach along the axes."""
    reach: Float64Array = (np.abs(rotation) @ half[..., None])[..., 0]
    return reach


def _iou_at_most(overlap: Float64Array, half: Float64Array, other_half: Float64Array) -> Float64Array:
    """The IoU (P,) of boxes that share no more than an overlap (P, 3), nor than the smaller one's volume."""
    volume, other = (8 * h.prod(axis=1) for h in (half, other_half))
    most = np.minimum(overlap.clip(min=0).prod(axis=1), np.minimum(volume, other))
    iou: Float64Array = most / np.maximum(volume + other - most, 1e-12)
    return iou


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
