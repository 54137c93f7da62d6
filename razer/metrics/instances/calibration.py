"""Expected calibration error: how well confidences say how often predictions are right (Guo et al., ICML 2017)."""

from __future__ import annotations

from typing import Any

import numpy as np

from razer.arrays import BoolArray, Float64Array

N_BINS = 10


def calibration(confidences: Float64Array, is_right: BoolArray) -> dict[str, Any] | None:
    """ece = sum over bins of n / N * |accuracy - mean confidence|, and `bins`: range, n, mean_confidence, accuracy of
    each tenth of [0, 1] that holds a prediction.

    confidences (N,) of predictions and whether each is_right (N,); None where there are none, or a confidence lies
    outside [0, 1], which is no probability then."""
    if not len(confidences) or confidences.min() < 0 or confidences.max() > 1:
        return None
    number = np.minimum((confidences * N_BINS).astype(np.int64), N_BINS - 1)
    bins = [_bin(i, confidences[number == i], is_right[number == i]) for i in np.unique(number).tolist()]
    gaps = [part["n"] * abs(part["accuracy"] - part["mean_confidence"]) for part in bins]
    return {"ece": sum(gaps) / len(confidences), "bins": bins}


def _bin(number: int, confidences: Float64Array, is_right: BoolArray) -> dict[str, Any]:
    return {
        "range": [number / N_BINS, (number + 1) / N_BINS],
        "n": len(confidences),
        "mean_confidence": float(confidences.mean()),
        "accuracy": float(is_right.mean()),
    }
