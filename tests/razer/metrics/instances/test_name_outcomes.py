"""Accuracy and calibration of names on hand-made matches."""

from __future__ import annotations

import numpy as np
import pytest

from razer.metrics.instances.match_summary import Match
from razer.metrics.instances.name_outcomes import NameOutcome, name_outcomes, naming_metrics

CHAIR, COUCH = 1, 2


def test_names_of_matches_are_compared_with_those_of_their_truths():
    matches = [Match(10, 1, 0.9), Match(11, 2, 0.6), Match(12, 3, 0.8), Match(13, 4, 0.7)]
    truth = {10: CHAIR, 11: CHAIR, 12: COUCH}  # what 13 is nobody knows
    predicted = {1: CHAIR, 2: COUCH, 4: COUCH}  # 3 has no name
    right, wrong, unnamed = name_outcomes(matches, truth, predicted, {1: 0.8, 2: 0.6, 4: 0.9})
    assert right == (True, 0.8)
    assert wrong == (False, 0.6)
    assert not unnamed.is_right
    assert np.isnan(unnamed.probability)


def test_metrics_by_hand():
    outcomes = [NameOutcome(True, 0.9), NameOutcome(False, 0.7), NameOutcome(True, 0.75), NameOutcome(False, np.nan)]
    metrics = naming_metrics(outcomes)
    assert (metrics["n"], metrics["accuracy"]) == (4, 0.5)
    assert metrics["ece"] == pytest.approx((0.1 + abs(2 * 0.5 - 1.45)) / 3)
    assert [part["n"] for part in metrics["bins"]] == [2, 1]
    unrated = naming_metrics([NameOutcome(True, np.nan)])
    assert (unrated["ece"], unrated["bins"], unrated["accuracy"]) == (None, None, 1)
    assert naming_metrics([]) is None
