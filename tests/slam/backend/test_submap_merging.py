"""When merge hypotheses suffice to merge two submaps."""

from __future__ import annotations

import numpy as np

from slam.backend.pose_graph import PoseEdge
from slam.backend.submap_merging import MergeHypothesis, SubmapMerging


def shift(z_m):
    result = np.eye(4)
    result[2, 3] = z_m
    return result


def hypothesis(frame, z_m, strength=1.0):
    return MergeHypothesis(frame, PoseEdge(0, 9, np.eye(4), np.eye(6)), shift(z_m), strength)


def test_three_views_that_agree_tie_a_piece_the_strongest_first():
    ties = SubmapMerging()
    assert not ties.add(0, 1, hypothesis(5, 2.0, 0.4))
    assert not ties.add(0, 1, hypothesis(6, 2.1, 0.9))
    agreeing = ties.add(0, 1, hypothesis(7, 2.05, 0.6))
    assert [w.strength for w in agreeing] == [0.9, 0.6, 0.4]


def test_one_view_counts_once_however_many_keyframes_it_fits():
    ties = SubmapMerging()
    assert not any(ties.add(0, 1, hypothesis(5, 2.0)) for _ in range(6))


def test_places_that_look_alike_wait_for_a_majority():
    ties = SubmapMerging()
    for frame in range(3):
        assert not ties.add(0, 1, hypothesis(frame, 0.0)) or frame == 2
    ties = SubmapMerging()
    for frame in range(2):
        ties.add(0, 1, hypothesis(frame, 0.0))
        ties.add(0, 1, hypothesis(frame, 2.26))
    assert not ties.add(0, 1, hypothesis(2, 2.26))  # three against two
    assert len(ties.add(0, 1, hypothesis(3, 2.26))) == 4


def test_pairs_of_pieces_are_told_apart_and_forgotten_with_a_submap():
    ties = SubmapMerging()
    for frame, submap in ((1, 1), (2, 2), (3, 1)):
        assert not ties.add(0, submap, hypothesis(frame, 0.0))
    ties.forget(1)
    assert not ties.add(0, 1, hypothesis(4, 0.0))
    assert not ties.add(0, 2, hypothesis(5, 0.0))
    assert ties.add(0, 2, hypothesis(6, 0.0))
