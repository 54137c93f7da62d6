"""Which pairs of pictures are registered."""

from __future__ import annotations

from itertools import combinations, pairwise

import numpy as np
import pytest

from razer.geometry import inverse
from slam.config import SlamConfig
from slam.frontend.rigid_matches import RigidMotion
from slam.pose_edge import PoseEdge
from slam.se3 import exp_se3
from slam.sparse.measured_pair import MeasuredPair
from slam.sparse.picture_matching import ENOUGH_WAYS, MOST_PROBES, PictureMatching

N = 40


def at(number):
    return exp_se3(np.array([0, 0.1 * number, 0, 0.3 * number, 0, 0]))


class Told(PictureMatching):
    """Made-up pictures: which of them share something is told, and how they lie; `asked`: what was registered."""

    def __init__(self, shares, rigid=lambda a, b: inverse(at(a)) @ at(b)):
        super().__init__([], SlamConfig())
        self._consecutive = set(pairwise(range(N)))
        self.shares, self.rigid, self.asked = shares, rigid, []

    def _rigid_motion(self, a, b):
        return RigidMotion(self.rigid(a, b), 100 - abs(a - b)) if self.shares(a, b) else None

    def _measure(self, a, b, guesses=()):
        self._tried.add((a, b))
        self.asked.append((a, b, len(guesses)))
        if not self.shares(a, b):
            return False
        pair = MeasuredPair(PoseEdge(a, b, inverse(at(a)) @ at(b), np.eye(6)), 50, 0.5)
        self._measured[a, b] = pair
        self._ties[a][b] = self._ties[b][a] = pair
        return True


def test_pictures_that_follow_each_other_are_all_registered_where_some_show_the_same():
    """A quarter of these does: the rest may have no texture."""
    matching = Told(lambda a, _: a % 3 == 0)
    matching.measure_consecutive()
    assert sorted(matching.asked) == [(a, a + 1, 1) for a in range(N - 1)]


def test_of_shuffled_pictures_few_are_tried_because_they_follow_each_other():
    matching = Told(lambda a, b: False)
    matching.measure_consecutive()
    assert 1 < len(matching.asked) <= MOST_PROBES
    matching.measure(combinations(range(N), 2))
    assert len(matching.asked) <= MOST_PROBES  # nothing else shares a feature


@pytest.mark.parametrize("n_pictures", [0, 1])
def test_nothing_follows_anything(n_pictures):
    matching = PictureMatching([], SlamConfig())
    matching._consecutive = set(pairwise(range(n_pictures)))
    matching.measure_consecutive()
    matching.measure([])
    assert matching.pairs == []


def test_what_shares_most_comes_first_and_what_others_tell_not_at_all():
    matching = Told(lambda a, b: b - a < 30)
    matching.measure(combinations(range(N), 2))
    apart = [b - a for a, b, _ in matching.asked]
    assert apart == sorted(apart)
    n_sharing = sum(b - a < 30 for a, b in combinations(range(N), 2))
    assert N - 1 < len(apart) < 0.7 * n_sharing
    measured = {(a, b) for a, b, _ in matching.asked}
    for a, b in combinations(range(N), 2):
        if b - a < 30 and (a, b) not in measured:
            assert len(matching._ties[a].keys() & matching._ties[b].keys()) >= ENOUGH_WAYS


def test_what_contradicts_all_others_is_registered():
    """Features put the last two half a metre from where the ways round by others have them: one of both is wrong."""
    off = exp_se3(np.array([0, 0, 0, 0.5, 0, 0]))
    last = N - 30, N - 1
    matching = Told(
        lambda a, b: b - a < 30, lambda a, b: inverse(at(a)) @ at(b) @ (off if (a, b) == last else np.eye(4))
    )
    matching.measure(combinations(range(N), 2))
    assert (*last, 0) in matching.asked


def test_nothing_is_registered_twice():
    matching = Told(lambda a, b: b - a < 4)
    matching.measure_consecutive()
    matching.measure(combinations(range(N), 2))
    matching.measure(combinations(range(N), 2))
    asked = [(a, b) for a, b, _ in matching.asked]
    assert len(asked) == len(set(asked))


def test_what_was_compared_in_vain_is_told_from_what_others_tell_and_from_what_was_not_compared():
    matching = Told(lambda a, b: (a < 20) == (b < 20))
    asked = [(a, b) for a, b in combinations(range(N), 2) if b != 39]
    matching.measure(asked)
    assert matching.unrecognised == {(a, b) for a, b in asked if a < 20 <= b}
    assert len(matching.pairs) < len(asked) - len(matching.unrecognised)  # of the others some were left out
