"""Accuracy and calibration of names: how often the class of a matched instance is right, and what its probability
said."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any, NamedTuple

import numpy as np

from razer.metrics.instances.calibration import calibration
from razer.metrics.instances.match_summary import Match


class NameOutcome(NamedTuple):
    """The name of a matched instance: whether it is the true one, and its probability, nan if it has none."""

    is_right: bool
    probability: float


def name_outcomes(
    matches: Sequence[Match], truth: Mapping[int, int], predicted: Mapping[int, int], probabilities: Mapping[int, float]
) -> tuple[NameOutcome, ...]:
    """The outcome of each match whose true instance has a class.

    Args:
        matches: at IoU 0.5.
        truth: class of true instances, by id.
        predicted: class of predicted instances, by id; one without a class is wrong.
        probabilities: of the predicted classes, by id.
    """
    return tuple(
        NameOutcome(predicted.get(match.predicted) == truth[match.truth], probabilities.get(match.predicted, np.nan))
        for match in matches
        if match.truth in truth
    )


def naming_metrics(outcomes: Sequence[NameOutcome]) -> dict[str, Any] | None:
    """n, accuracy, and of those with a probability ece and bins as in `calibration`, None where there are none; None
    without outcomes."""
    if not outcomes:
        return None
    rated = [outcome for outcome in outcomes if not np.isnan(outcome.probability)]
    probability = np.array([outcome.probability for outcome in rated], np.float64)
    table = calibration(probability, np.array([outcome.is_right for outcome in rated], np.bool_)) or {}
    accuracy = float(np.mean([outcome.is_right for outcome in outcomes]))
    return {"n": len(outcomes), "accuracy": accuracy, "ece": table.get("ece"), "bins": table.get("bins")}
