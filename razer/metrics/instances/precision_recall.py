"""Precision over recall of ranked predictions, and the area under it."""

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


def average_precision(scores: Float64Array, right: BoolArray, missed: int) -> float:
    """Area under precision over recall as the ScanNet benchmark sums it: at each distinct score the predictions that
    score as much or more count; then a last point of precision 1 and recall 0; each precision is weighted by half the
    distance of its neighbours' recalls. scores and right (N,) hold every prediction that counts."""
    if len(scores) == 0:
        return 0.0
    _, right_above, above = _points(scores, right)
    precision = np.append(right_above / above, 1.0)
    # Recalls times the number of truths, which keeps a perfect result exactly 1.
    found = np.append(right_above, 0.0)
    steps = np.convolve(np.concatenate([found[:1], found, [0.0]]), [-0.5, 0, 0.5], "valid")
    return float(precision @ steps) / max(int(right.sum()) + missed, 1)


def precision_recall(scores: Float64Array, right: BoolArray, missed: int) -> Curve:
    """The points that average_precision sums over, without the last one."""
    if len(scores) == 0:
        return Curve(np.zeros(0), np.zeros(0), np.zeros(0))
    distinct, right_above, above = _points(scores, right)
    return Curve(distinct, right_above / above, right_above / max(int(right.sum()) + missed, 1))


def _points(scores: Float64Array, right: BoolArray) -> tuple[Float64Array, Int64Array, Int64Array]:
    """Each distinct score, increasing, with how many right ones and how many in all score as much or more."""
    order = np.argsort(scores, kind="stable")
    distinct, first = np.unique(scores[order], return_index=True)
    right_above = right.sum() - np.concatenate([[0], np.cumsum(right[order])])[first]
    return distinct, right_above, len(scores) - first
