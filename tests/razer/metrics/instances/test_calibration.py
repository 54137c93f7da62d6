"""Expected calibration error on hand-made cases."""

from __future__ import annotations

import numpy as np
import pytest

from razer.metrics.instances.calibration import calibration


def test_error_and_bins_by_hand():
    confidences = np.array([0.95, 0.91, 0.99, 1.0, 0.15, 0.25, 0.3])
    right = np.array([True, True, False, True, False, True, False])
    result = calibration(confidences, right)
    assert [(b["n"], b["range"]) for b in result["bins"]] == [
        (1, [0.1, 0.2]),
        (1, [0.2, 0.3]),
        (1, [0.3, 0.4]),
        (4, [0.9, 1.0]),
    ]
    last = result["bins"][-1]
    assert last["mean_confidence"] == pytest.approx(0.9625)
    assert last["accuracy"] == 0.75
    gaps = [0.15, 0.75, 0.3, 4 * (0.9625 - 0.75)]
    assert result["ece"] == pytest.approx(sum(gaps) / 7)


def test_perfect_and_impossible_confidences():
    rng = np.random.default_rng(0)
    confidences = rng.random(200_000)
    assert calibration(confidences, rng.random(200_000) < confidences)["ece"] < 0.01
    assert calibration(np.ones(3), np.ones(3, bool))["ece"] == 0
    assert calibration(np.zeros(0), np.zeros(0, bool)) is None
    assert calibration(np.array([0.5, 31.0]), np.array([True, False])) is None
