"""When merge hypotheses suffice to believe where a submap lies."""

from __future__ import annotations

import numpy as np
import pytest

from slam.backend.pose_graph import PoseEdge
from slam.backend.submaps.merge_hypotheses import MergeHypotheses, MergeHypothesis
from slam.frontend.keyframes import Keyframe
from slam.submap_settings import SubmapSettings


def at(z_m):
    result = np.eye(4)
    result[2, 3] = z_m
    return result


def keyframes(*parties):
    """Keyframes of (submap, chain) each, five metres apart along the axis."""
    return [Keyframe(n, submap, None, at(5.0 * n), 0.0, chain) for n, (submap, chain) in enumerate(parties)]


def hypothesis(frame, z_m, a=0, b=1, strength=1.0):
    """That keyframe b lies z_m before keyframe a."""
    return MergeHypothesis(frame, PoseEdge(a, b, at(z_m), np.eye(6)), strength)


@pytest.fixture
def hypotheses():
    return MergeHypotheses(keyframes((0, 0), (1, 1), (2, 2)), SubmapSettings())


def added(hypotheses, one):
    hypotheses.add(one)
    return hypotheses.enough(one)


def test_three_views_that_agree_are_enough_the_strongest_first(hypotheses):
    assert not added(hypotheses, hypothesis(5, 2.0, strength=0.4))
    assert not added(hypotheses, hypothesis(6, 2.1, strength=0.9))
    agreeing = added(hypotheses, hypothesis(7, 2.05, strength=0.6))
    assert [one.strength for one in agreeing] == [0.9, 0.6, 0.4]
    np.testing.assert_allclose(hypotheses.shift(agreeing[0]), at(2.1 - 5.0))


def test_one_view_counts_once_however_many_keyframes_it_fits(hypotheses):
    assert not any(added(hypotheses, hypothesis(5, 2.0)) for _ in range(6))


def test_places_that_look_alike_wait_for_a_majority(hypotheses):
    for frame in range(2):
        added(hypotheses, hypothesis(frame, 0.0))
        added(hypotheses, hypothesis(frame, 2.26))
    assert not added(hypotheses, hypothesis(2, 2.26))  # three against two
    assert len(added(hypotheses, hypothesis(3, 2.26))) == 4


def test_pairs_of_submaps_are_kept_apart(hypotheses):
    for frame, submap in ((1, 1), (2, 2), (3, 1), (4, 2)):
        assert not added(hypotheses, hypothesis(frame, 0.0, b=submap))
    assert len(added(hypotheses, hypothesis(5, 0.0, b=2))) == 3


def test_what_was_refuted_must_come_up_anew(hypotheses):
    for frame in range(3):
        agreeing = added(hypotheses, hypothesis(frame, 2.0))
    hypotheses.refute(agreeing)
    assert not added(hypotheses, hypothesis(3, 2.0))
    assert not added(hypotheses, hypothesis(4, 2.0))
    assert len(added(hypotheses, hypothesis(5, 2.0))) == 3


def frames_until_enough(hypotheses, z_m, first):
    """How many views must say that keyframe 1 lies z_m before keyframe 0; and then it is refused."""
    for n in range(1, 50):
        agreeing = added(hypotheses, hypothesis(first + n, z_m))
        if agreeing:
            hypotheses.refuse(agreeing)
            return n
    return None


def test_each_time_that_a_place_is_refused_twice_as_many_must_say_it_again(hypotheses):
    assert [frames_until_enough(hypotheses, 2.0, 100 * n) for n in range(4)] == [3, 6, 12, 24]


def test_a_place_that_was_refused_stands_in_the_way_of_no_other(hypotheses):
    assert frames_until_enough(hypotheses, 2.0, 100) == 3
    for frame in range(200, 205):
        assert not added(hypotheses, hypothesis(frame, 2.0))
    assert frames_until_enough(hypotheses, 9.0, 300) == 3


def test_agreement_is_of_where_views_are_and_not_of_a_far_origin():
    """Two degrees about a place a hundred metres away from the origin are one place, and 3.5 m there."""
    far = [Keyframe(0, 0, None, at(0.0), 0.0, 0), Keyframe(1, 1, None, at(100.0), 0.0, 1)]
    kept = MergeHypotheses(far, SubmapSettings())
    for frame, turn_rad in enumerate((0.0, np.radians(2.0), np.radians(1.0))):
        turned = np.eye(4)
        turned[:3, :3] = [[np.cos(turn_rad), 0, np.sin(turn_rad)], [0, 1, 0], [-np.sin(turn_rad), 0, np.cos(turn_rad)]]
        one = MergeHypothesis(frame, PoseEdge(0, 1, turned, np.eye(6)), 1.0)
        agreeing = added(kept, one)
    assert len(agreeing) == 3


def test_within_a_submap_the_later_chain_is_moved_and_what_is_in_place_does_not_count():
    kept = MergeHypotheses(keyframes((0, 0), (0, 1)), SubmapSettings())
    for frame in range(9):
        assert not added(kept, hypothesis(frame, 5.0))  # as it is
    for frame in range(9, 12):
        agreeing = added(kept, hypothesis(frame, 1.0))
    assert len(agreeing) == 3
    np.testing.assert_allclose(kept.shift(agreeing[0]), at(-4.0))
    assert kept.ends(agreeing[0])[1].chain == 1


def test_where_other_submaps_are_expected_both_ways_round(hypotheses):
    for frame, z_m in enumerate((2.0, 2.0, 9.0)):
        hypotheses.add(hypothesis(frame, z_m))
    ((other, shift),) = hypotheses.expected(1)
    assert other == 0
    np.testing.assert_allclose(shift, at(-3.0))
    ((other, shift),) = hypotheses.expected(0)
    assert other == 1
    np.testing.assert_allclose(shift, at(3.0))
    assert hypotheses.expected(2) == []


def test_a_place_that_was_refused_hides_none_that_was_not(hypotheses):
    """The look-alike goes on to have more views, and may yet prove right."""
    hypotheses.refuse([hypothesis(frame, 2.0) for frame in range(3)])
    for frame in range(3, 7):
        hypotheses.add(hypothesis(frame, 2.0))
    assert [shift[2, 3] for _, shift in hypotheses.expected(1)] == pytest.approx([2.0 - 5.0])
    hypotheses.add(hypothesis(7, 9.0))
    assert [shift[2, 3] for _, shift in hypotheses.expected(1)] == pytest.approx([2.0 - 5.0, 9.0 - 5.0])
