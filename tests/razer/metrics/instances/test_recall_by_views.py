"""Recall by views: every instance is in one bin, and bins say how many of it were found."""

from __future__ import annotations

import numpy as np

from razer.metrics.instances.recall_by_views import ViewedInstance, recall_by_views


def test_bins_by_hand():
    found = [(0, False), (1, False), (2, True), (3, True), (10, True), (6, False), (40, True)]
    assert recall_by_views([ViewedInstance(*one) for one in found], 40) == [
        {"views": [0, 0], "n": 1, "recall50": 0.0},
        {"views": [1, 2], "n": 2, "recall50": 0.5},
        {"views": [3, 5], "n": 1, "recall50": 1.0},
        {"views": [6, 10], "n": 2, "recall50": 0.5},
        {"views": [21, 40], "n": 1, "recall50": 1.0},
    ]


def test_each_instance_is_in_one_bin():
    rng = np.random.default_rng(0)
    for n_frames in (1, 2, 7, 50, 5000):
        instances = [ViewedInstance(int(v), bool(v % 2)) for v in rng.integers(0, n_frames + 1, 300)]
        bins = recall_by_views(instances, n_frames)
        assert sum(part["n"] for part in bins) == 300
        found = sum(part["n"] * part["recall50"] for part in bins)
        assert round(found) == sum(instance.matched for instance in instances)
        edges = [edge for part in bins for edge in part["views"]]
        assert edges == sorted(edges)
        assert edges[-1] <= n_frames
