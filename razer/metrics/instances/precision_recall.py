"""Precision-recall curve of ranked predictions, and average precision as the area under it."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from razer.arrays import BoolArray, Float64Array, Int64Array


@dataclass(frozen=True, slots=True)
class Curve:
    """Precision and recall (N,) of the predictions that score at least `scores` (N,), which increase."""

    scores: Float64Array
    precision: Float64Array
    recall: Float64Array


def average_precision(scores: Float64Array, is_true_positive: BoolArray, n_missed: int) -> float:
    """Area under precision over recall as the ScanNet benchmark sums it: at each distinct score the predictions that
    score as much or more count; then a last point of precision 1 and recall 0; each precision is weighted by half the
    distance of its neighbours' recalls. scores and is_true_positive (N,) hold every prediction that
    counts, n_missed is the number of false negatives."""
    if len(scores) == 0:
        return 0.0
    _, true_above, above = _points(scores, is_true_positive)
    precision = np.append(true_above / above, 1.0)
    # Recalls times the number of truths, which keeps a perfect result exactly 1.
    recalled = np.append(true_above, 0.0)
    steps = np.convolve(np.concatenate([recalled[:1], recalled, [0.0]]), [-0.5, 0, 0.5], "valid")
    return float(precision @ steps) / max(int(is_true_positive.sum()) + n_missed, 1)


def precision_recall(scores: Float64Array, is_true_positive: BoolArray, n_missed: int) -> Curve:
    """The points that average_precision sums over, without the last one."""
    if len(scores) == 0:
        return Curve(np.zeros(0), np.zeros(0), np.zeros(0))
    distinct, true_above, above = _points(scores, is_true_positive)
    return Curve(distinct, true_above / above, true_above / max(int(is_true_positive.sum()) + n_missed, 1))


def _points(scores: Float64Array, is_true_positive: BoolArray) -> tuple[Float64Array, Int64Array, Int64Array]:
    """Each distinct score, increasing, with how many true positives and how many in all score as much or more."""
    order = np.argsort(scores, kind="stable")
    distinct, first = np.unique(scores[order], return_index=True)
    true_above = is_true_positive.sum() - np.concatenate([[0], np.cumsum(is_true_positive[order])])[first]
    return distinct, true_above, len(scores) - first
