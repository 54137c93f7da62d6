"""Differences of two evaluations, number by number."""

from __future__ import annotations

from app.comparison.against_truth import differences


def test_deltas_are_of_numbers_alone():
    a = {"x": 1.0, "n": None, "name": "a", "on": True, "deep": {"y": 2, "z": {"w": 1}}, "only": 3, "list": [1]}
    b = {"x": 1.5, "n": 2.0, "name": "b", "on": False, "deep": {"y": 1, "z": None}, "list": [2]}
    assert differences(a, b) == {"x": 0.5, "n": None, "deep": {"y": -1, "z": None}}
