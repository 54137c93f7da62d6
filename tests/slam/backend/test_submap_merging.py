"""When merge hypotheses suffice to merge two submaps."""

from __future__ import annotations

import numpy as np

from slam.backend.submap_merging import MergeHypothesis, SubmapMerging
from slam.config import SubmapSettings
from slam.pose_edge import PoseEdge


def shift(z_m):
    result = np.eye(4)
    result[2, 3] = z_m
    return result


def hypothesis(frame, z_m, strength=1.0):
    return MergeHypothesis(frame, PoseEdge(0, 9, np.eye(4), np.eye(6)), shift(z_m), strength)


def test_three_views_that_agree_merge_a_submap_the_strongest_first():
    merging = SubmapMerging(SubmapSettings())
    assert not merging.add(0, 1, hypothesis(5, 2.0, 0.4))
    assert not merging.add(0, 1, hypothesis(6, 2.1, 0.9))
    agreeing = merging.add(0, 1, hypothesis(7, 2.05, 0.6))
    assert [one.strength for one in agreeing] == [0.9, 0.6, 0.4]


def test_one_view_counts_once_however_many_keyframes_it_fits():
    merging = SubmapMerging(SubmapSettings())
    assert not any(merging.add(0, 1, hypothesis(5, 2.0)) for _ in range(6))


def test_places_that_look_alike_wait_for_a_majority():
    merging = SubmapMerging(SubmapSettings())
    for frame in range(3):
        assert not merging.add(0, 1, hypothesis(frame, 0.0)) or frame == 2
    merging = SubmapMerging(SubmapSettings())
    for frame in range(2):
        merging.add(0, 1, hypothesis(frame, 0.0))
        merging.add(0, 1, hypothesis(frame, 2.26))
    assert not merging.add(0, 1, hypothesis(2, 2.26))  # three against two
    assert len(merging.add(0, 1, hypothesis(3, 2.26))) == 4


def test_pairs_of_submaps_are_kept_apart_and_forgotten_with_a_submap():
    merging = SubmapMerging(SubmapSettings())
    for frame, submap in ((1, 1), (2, 2), (3, 1)):
        assert not merging.add(0, submap, hypothesis(frame, 0.0))
    merging.forget(1)
    assert not merging.add(0, 1, hypothesis(4, 0.0))
    assert not merging.add(0, 2, hypothesis(5, 0.0))
    assert merging.add(0, 2, hypothesis(6, 0.0))
