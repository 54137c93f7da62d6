"""Detections to tracks: candidates from the R-tree, the cost M = w_v V + w_s S, a gate, and the cheapest
assignment of each connected group (section III-C, eq. 8)."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import linear_sum_assignment
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components

from razer.box_overlap import box_containment, box_iou
from razer.boxes import OrientedBox
from razer.config import AssociationSettings
from razer.embedding import bank_similarity
from razer.evidence import LabelEvidence
from razer.index import BoxIndex
from razer.lifting import Detection
from razer.step import Candidate
from razer.track import Track

# Costs above the gate are replaced by this, so that the assignment prefers any allowed pair.
FORBIDDEN = 1e3


def find_candidates(
    detections: Sequence[Detection],
    tracks: Mapping[int, Track],
    index: BoxIndex,
    evidence: LabelEvidence,
    settings: AssociationSettings,
) -> list[tuple[Candidate, ...]]:
    """For each detection the tracks it may belong to, cheapest first."""
    pairs = [(i, t) for i, d in enumerate(detections) for t in _nearby(i, d, index, evidence, settings, tracks)]
    if not pairs:
        return [()] * len(detections)
    rows, ids = np.array([i for i, _ in pairs]), [t for _, t in pairs]
    overlap = _overlaps(detections, tracks, pairs, evidence, settings)
    known = sorted(set(ids))
    cosines = bank_similarity([tracks[t].bank for t in known], np.stack([d.embedding for d in detections]))
    cosine = cosines[np.searchsorted(known, ids), rows]
    cost = settings.weight_geometry * (1 - overlap) + settings.weight_semantic * (1 - cosine)
    found: list[list[Candidate]] = [[] for _ in detections]
    for (i, t), v, s, m in zip(pairs, 1 - overlap, 1 - cosine, cost, strict=True):
        found[i].append(Candidate(t, float(v), float(s), float(m)))
    return [tuple(sorted(row, key=lambda c: (c.cost, c.track_id))) for row in found]


def _nearby(
    detection: int,
    found: Detection,
    index: BoxIndex,
    evidence: LabelEvidence,
    settings: AssociationSettings,
    tracks: Mapping[int, Track],
) -> list[int]:
    near = set(index.near(found.box, settings.search_margin_m))
    if settings.association == "visible":
        near |= {t for (d, t) in evidence.shared if d == detection and t in tracks}
    return sorted(near)


def _overlaps(
    detections: Sequence[Detection],
    tracks: Mapping[int, Track],
    pairs: Sequence[tuple[int, int]],
    evidence: LabelEvidence,
    settings: AssociationSettings,
) -> NDArray[np.float64]:
    """1 - V_ij (P,) of each pair, by the chosen measure."""
    # A wall seen flat has no volume: half a hand's breadth on every side gives thin boxes an overlap.
    margin_m = settings.search_margin_m / 4
    grown = [d.box.grown(margin_m) for d in detections]
    tracked = {t: tracks[t].box.grown(margin_m) for t in {t for _, t in pairs}}
    first, second = [grown[i] for i, _ in pairs], [tracked[t] for _, t in pairs]
    if settings.association == "paper":
        return box_iou([detections[i].box for i, _ in pairs], [tracks[t].box for _, t in pairs])
    if settings.association == "containment":
        return box_containment(first, second)
    seen = np.array([evidence.visible_iou(i, t) for i, t in pairs])
    return np.maximum(seen, _box_iou_where_needed(first, second, seen))


def _box_iou_where_needed(
    first: Sequence[OrientedBox], second: Sequence[OrientedBox], seen: NDArray[np.float64]
) -> NDArray[np.float64]:
    """Box IoU of the pairs for which it could exceed what is seen already, 0 for the others.

    Two boxes share at most the smaller volume, and at most what their axis-aligned bounds share.
    """
    bounds = {id(box): (*box.enclosing_bounds(), box.volume) for box in (*first, *second)}
    a, b = (np.array([bounds[id(box)] for box in boxes]) for boxes in (first, second))
    overlap = np.clip(np.minimum(a[:, 3:6], b[:, 3:6]) - np.maximum(a[:, :3], b[:, :3]), 0, None).prod(axis=1)
    most = np.minimum(overlap, np.minimum(a[:, 6], b[:, 6]))
    needed = np.flatnonzero(most > seen * (a[:, 6] + b[:, 6] - most)).tolist()
    result = np.zeros(len(seen))
    result[needed] = box_iou([first[i] for i in needed], [second[i] for i in needed])
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
