"""What all pairs together say of each, and which are registered."""

from __future__ import annotations

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

from slam.config import SlamConfig
from slam.pose_edge import PoseEdge
from slam.sparse.known_pairs import LEAST_SUPPORT, LEAST_USUAL, KnownPairs, as_it_is
from slam.sparse.measured_pair import MeasuredPair

CONFIG = SlamConfig()
KEYFRAMES = [SimpleNamespace(view=SimpleNamespace(stamp=float(n))) for n in range(9)]


def pair(a, b, n_features=50, **more):
    return MeasuredPair(PoseEdge(a, b, np.eye(4), np.eye(6)), n_features, 0.5, **more)


def known(pairs, support=(), register=as_it_is, sure_colors=()):
    result = KnownPairs(KEYFRAMES, pairs, CONFIG, sure_colors=sure_colors, register=register)
    result._support |= dict(support)
    return result


def test_a_pair_is_registered_once_wherever_it_is_asked_for():
    asked = []

    def register(rough):
        asked.append(rough.ends)
        return replace(rough, n_features=99, is_registered=True)

    rough, done = pair(0, 1, is_registered=False, is_next=True), pair(1, 2)
    pairs = known([rough, done], register=register)
    for _ in range(2):
        assert pairs.registered(rough).n_features == 99
        assert pairs.registered(done) is done
    assert asked == [(0, 1)]
    assert pairs.by_number[1][0] is pairs.supported[0][1] is pairs.registered(rough)
    assert pairs.registered(rough).is_next


def test_what_cannot_be_registered_is_no_pair():
    rough = pair(0, 1, is_registered=False)
    pairs = known([rough, pair(1, 2)], register=lambda _: None)
    assert pairs.registered(rough) is None
    assert pairs.registered(rough) is None
    assert [one.ends for one in pairs] == [(1, 2)]
    assert 1 not in pairs.by_number[0]
    assert 0 not in pairs.supported[1]


@pytest.mark.parametrize(
    ("support", "vote"),
    [(0.0, 1.0), (LEAST_SUPPORT / 2, 0.5), (LEAST_SUPPORT, 0.1), (-99.0, 0.1), (5.0, 2.0), (99.0, 2.0)],
)
def test_a_vote_counts_by_what_speaks_for_it(support, vote):
    one = pair(0, 1)
    pairs = known([one], {(0, 1): support})
    assert pairs.vote(one) == pytest.approx(vote)
    assert pairs.vote(replace(one, is_next=True)) == 2.0


def test_pairs_are_unsupported_together_by_how_much_each_weighs():
    heavy, light = pair(0, 1, 90), pair(2, 3, 10)
    pairs = known([heavy, light], {(0, 1): LEAST_SUPPORT - 1, (2, 3): 3.0})
    assert pairs.are_unsupported([heavy])
    assert pairs.are_unsupported([heavy, light])
    assert not pairs.are_unsupported([light])
    assert not pairs.are_unsupported([replace(heavy, is_next=True), light])


def test_colours_where_pictures_are_placed_are_held_to_those_of_registered_pairs():
    """Depth puts a hand-held camera's pictures where more of their colours differ than where features do."""
    rough = [pair(0, n, other_colors=0.01, separation=0.5) for n in range(1, 9)]
    pairs = known(rough * 2, sure_colors=[(0.5, 0.06)] * 20)
    assert pairs.usual_where_placed.at([0.5])[0] == pytest.approx(0.06)
    assert pairs.usual_colors.at([0.5])[0] == pytest.approx(0.01)
    alone = known(rough * 2)
    assert alone.usual_where_placed.at([0.5])[0] == pytest.approx(0.01)
    assert known([replace(one, other_colors=0.0) for one in rough * 2]).usual_colors.at([0.1])[0] == LEAST_USUAL
