"""Labels carried from one surface's vertices to another's."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree


def transfer_labels(
    predicted_vertices: NDArray[np.floating],
    predicted_ids: NDArray[np.integer],
    truth_vertices: NDArray[np.floating],
    max_distance_m: float = 0.05,
    k: int = 1,
) -> NDArray[np.int64]:
    """The label (V,) of each truth vertex (V, 3): that of the nearest of the (P, 3) predicted vertices, or of most
    of the k nearest (a tie goes to the lower label), within max_distance_m metres; 0 where there is none."""
    labels = np.append(np.asarray(predicted_ids, np.int64), 0)
    if len(predicted_vertices) == 0:
        return np.zeros(len(truth_vertices), np.int64)
    tree = cKDTree(predicted_vertices)
    # Missing neighbours get the index one past the end, whose label is 0.
    beyond = np.nextafter(max_distance_m, np.inf)
    distance, index = tree.query(truth_vertices, k=list(range(1, k + 1)), distance_upper_bound=beyond)
    near = np.where(np.isfinite(distance), labels[index], 0)
    return near[:, 0] if k == 1 else _majority(near, np.isfinite(distance))


def _majority(labels: NDArray[np.int64], valid: NDArray[np.bool_]) -> NDArray[np.int64]:
    """The most frequent valid label of each row, the lowest of equally frequent ones; 0 for rows without any."""
    votes = ((labels[:, :, None] == labels[:, None, :]) & valid[:, None, :]).sum(axis=2) * valid
    best = np.where(votes == votes.max(axis=1, keepdims=True), labels, np.iinfo(np.int64).max).min(axis=1)
    return np.where(valid.any(axis=1), best, 0)
