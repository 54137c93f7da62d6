"""Which pairs of pictures are compared, which are left out, and which are registered."""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from itertools import combinations, pairwise
from types import SimpleNamespace

import numpy as np
import pytest

from razer.geometry import inverse
from slam.config import SlamConfig
from slam.frontend.color_calibration import ColorCalibration
from slam.frontend.icp import IcpResult
from slam.frontend.keyframes import Keyframe
from slam.frontend.rigid_matches import RigidMotion
from slam.se3 import exp_se3
from slam.sparse.measured_pair import MeasuredPair
from slam.sparse.picture_matching import (
    ALL_PAIRS_UP_TO,
    ENOUGH_WAYS,
    MOST_PROBES,
    SHORTLIST,
    SHORTLIST_IN_ORDER,
    PictureMatching,
)

N = 40


def at(number):
    return exp_se3(np.array([0, 0.1 * number, 0, 0.3 * number, 0, 0]))


@dataclass(frozen=True)
class View:
    """One of which only this matters."""

    stamp: float
    turning_rad_s: np.ndarray = field(default_factory=lambda: np.zeros(3))

    def turning(self, turning_rad_s):
        return replace(self, turning_rad_s=turning_rad_s)


class Told(PictureMatching):
    """Made-up pictures: which of them share something is told, and how they lie; `kept`: the pairs that were kept as
    their features have them, `asked`: what was registered, and from how many guesses."""

    def __init__(self, shares, rigid=lambda a, b: inverse(at(a)) @ at(b), stamps=range(N)):
        super().__init__([], SlamConfig())
        self.keyframes.all.extend(SimpleNamespace(view=View(stamp)) for stamp in stamps)
        self._consecutive = set(pairwise(range(N)))
        self.shares, self.rigid, self.kept, self.asked = shares, rigid, [], []

    def _rigid_motion(self, a, b):
        return RigidMotion(self.rigid(a, b), 100 - abs(a - b), np.eye(6)) if self.shares(a, b) else None

    def _pair(self, edge, n_features):
        self.kept.append((edge.a, edge.b))
        return MeasuredPair(edge, n_features, 0.5, is_registered=False)

    def _registered(self, a, b, guesses=()):
        self.asked.append((a, b, len(guesses)))
        if not self.shares(a, b):
            return None
        figures = {"overlap": 1.0, "agreement": 1.0, "fit": 1.0, "rms": 0.5, "n_features": 50}
        motion, calibration = inverse(at(a)) @ at(b), ColorCalibration.nominal()
        return IcpResult(motion, np.eye(6), np.eye(6), **figures, calibration=calibration)


def test_pictures_that_follow_each_other_are_all_registered_where_some_show_the_same():
    """A quarter of these does: the rest may have no texture."""
    matching = Told(lambda a, _: a % 3 == 0)
    matching.measure_consecutive()
    assert sorted(matching.asked) == [(a, a + 1, 1) for a in range(N - 1)]


def test_what_follows_in_vain_is_compared_by_all_features_before_anything_else():
    matching = Told(lambda a, b: a != 7 or (a, b) in matching._closely)
    matching.measure_consecutive()
    assert matching._closely == {(7, 8)}
    assert [pair.ends for pair in matching.pairs if not pair.is_registered] == [(7, 8)]
    assert all(pair.is_next for pair in matching.pairs)


def test_a_camera_that_turned_slowly_is_taken_to_have_stood():
    matching = Told(lambda a, b: True, stamps=[0.2 * n for n in range(N)])
    matching.measure_consecutive()
    assert not any(keyframe.view.turning_rad_s.any() for keyframe in matching.keyframes.all)
    assert len(matching.asked) == N - 1


def test_pictures_of_a_camera_that_turned_fast_are_registered_anew_as_it_turned():
    """Those of the others are not; of a third of all pairs nothing came, and nothing comes of them anew."""
    stamps = [0.125 * min(n, 20) + 0.6 * max(n - 20, 0) for n in range(N)]  # half a second and more is too long to tell
    matching = Told(lambda a, _: a % 3 > 0, stamps=stamps)
    matching.measure_consecutive()
    told = {n for n in range(N) if matching.keyframes[n].view.turning_rad_s.any()}
    assert told == set(range(1, 21))
    np.testing.assert_allclose([matching.keyframes[n].view.turning_rad_s for n in sorted(told)], [[0, 0.8, 0]] * 20)
    anew = [(a, b) for a, b, _ in matching.asked if matching.asked.count((a, b, 1)) == 2]
    assert set(anew) == {(a, a + 1) for a in range(21) if a % 3 > 0}


class Asked:
    """Registers nothing, and keeps what it was asked."""

    def __init__(self):
        self.asked = []

    def recognise(self, target, view, guesses, calibration, rigid):
        self.asked.append(("recognise", [guess[0, 3] for guess in guesses], rigid.is_sure))

    def register(self, target, view, guesses, calibration):
        self.asked.append(("register", [guess[0, 3] for guess in guesses], None))


@pytest.mark.parametrize(
    ("is_sure", "learnt", "asked"),
    [
        (True, {}, ("recognise", [], True)),
        (False, {}, ("recognise", [0.5], False)),
        (False, {(3, 4): exp_se3(np.array([0, 0, 0, 0.2, 0, 0]))}, ("register", [0.2], None)),
        (False, {(2, 3): np.eye(4)}, ("recognise", [0.5], False)),
    ],
)
def test_where_features_are_sure_no_guess_is_tried_and_what_was_registered_before_starts_from_there(
    is_sure, learnt, asked, monkeypatch
):
    matching = Told(lambda a, b: True)
    monkeypatch.setattr(type(matching.keyframes), "view", lambda self, keyframe: keyframe.view)
    monkeypatch.setattr(PictureMatching, "_matches", lambda self, a, b: SimpleNamespace(is_sure=is_sure))
    matching.registration, matching._learnt = Asked(), learnt
    guess = exp_se3(np.array([0, 0, 0, 0.5, 0, 0]))
    assert PictureMatching._registered(matching, 3, 4, [guess]) is None
    assert matching.registration.asked == [asked]


def test_of_shuffled_pictures_few_are_tried_because_they_follow_each_other():
    matching = Told(lambda a, b: False)
    matching.measure_consecutive()
    assert 1 < len(matching.asked) <= MOST_PROBES
    matching.measure(combinations(range(N), 2))
    assert len(matching.asked) <= MOST_PROBES  # nothing else shares a feature
    assert matching.pairs == []


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
    assert not matching.asked  # what features say comes first, and registrations when something rests on them
    apart = [b - a for a, b in matching.kept]
    assert apart == sorted(apart)
    n_sharing = sum(b - a < 30 for a, b in combinations(range(N), 2))
    assert N - 1 < len(apart) < 0.7 * n_sharing
    measured = set(matching.kept)
    for a, b in combinations(range(N), 2):
        if b - a < 30 and (a, b) not in measured:
            assert len(matching._ties[a].keys() & matching._ties[b].keys()) >= ENOUGH_WAYS


def test_what_contradicts_all_others_is_kept():
    """Features put the last two half a metre from where the ways round by others have them: one of both is wrong."""
    off = exp_se3(np.array([0, 0, 0, 0.5, 0, 0]))
    last = N - 30, N - 1
    matching = Told(
        lambda a, b: b - a < 30, lambda a, b: inverse(at(a)) @ at(b) @ (off if (a, b) == last else np.eye(4))
    )
    matching.measure(combinations(range(N), 2))
    assert last in matching.kept


def test_nothing_is_compared_twice():
    matching = Told(lambda a, b: b - a < 4)
    matching.measure_consecutive()
    matching.measure(combinations(range(N), 2))
    n_asked = len(matching.asked)
    matching.measure(combinations(range(N), 2))
    assert len(matching.asked) == n_asked
    compared = [(a, b) for a, b, _ in matching.asked]
    assert len(compared) == len(set(compared))
    assert len(matching.kept) == len(set(matching.kept))


def test_what_was_compared_in_vain_may_be_found_by_all_features():
    """Once more where it is asked for, and nothing else anew."""
    matching = Told(lambda a, b: b - a < 4 or ((a, b) in matching._closely and b - a < 8))
    matching.measure(combinations(range(10), 2))
    assert {(0, 5), (0, 9)} <= matching.unrecognised
    kept = list(matching.kept)
    matching.measure_closely([(0, 1), (0, 5), (0, 9)])
    assert matching.kept == [*kept, (0, 5)]
    assert (0, 5) not in matching.unrecognised
    assert (0, 9) in matching.unrecognised


def test_of_many_pictures_each_is_compared_with_those_that_look_most_alike(monkeypatch):
    matching, asked = PictureMatching([], SlamConfig()), []

    def lookalikes(numbers, among, most):
        asked.append((list(numbers), list(among), most))
        return {(0, 1), (3, 9)}

    monkeypatch.setattr(matching, "lookalikes", lookalikes)
    for n in (ALL_PAIRS_UP_TO, ALL_PAIRS_UP_TO + 1):
        matching.keyframes.all = [Keyframe(i, 0, None, np.eye(4), 0.0) for i in range(n)]
        matching._consecutive = set(pairwise(range(n)))
        all_pairs = [*combinations(range(n), 2)]
        assert matching.candidates() == (all_pairs if n == ALL_PAIRS_UP_TO else sorted([*pairwise(range(n)), (3, 9)]))
    assert asked == [(list(range(n)), list(range(n)), SHORTLIST)]


@pytest.mark.parametrize(("least", "shortlist"), [(N // 2, SHORTLIST_IN_ORDER), (N // 2 + 1, None)])
def test_in_the_order_of_taking_each_is_compared_with_those_alike_however_few_they_are(least, shortlist, monkeypatch):
    """Of 39 pairs of pictures that follow each other 20 are enough to tell, and 19 are not."""
    matching, asked = Told(lambda a, b: a >= least - 1), []
    monkeypatch.setattr(matching, "lookalikes", lambda *args: asked.append(args[2]) or {(0, 9)})
    matching.measure_consecutive()
    candidates = matching.candidates()
    assert asked == ([] if shortlist is None else [shortlist])
    assert candidates == sorted([*pairwise(range(N)), (0, 9)] if shortlist else combinations(range(N), 2))


def test_a_pair_lies_as_its_registration_says_and_keeps_the_colours_it_had():
    off = exp_se3(np.array([0, 0.05, 0, 0.1, 0, 0]))
    matching = Told(lambda a, b: b - a < 4, lambda a, b: inverse(at(a)) @ at(b) @ off)
    matching.measure([(0, 2)])
    (rough,) = matching.pairs
    registered = matching.register(replace(rough, other_colors=0.25))
    assert not rough.is_registered
    assert registered.is_registered
    np.testing.assert_allclose(rough.edge.a_from_b, inverse(at(0)) @ at(2) @ off)
    np.testing.assert_allclose(registered.edge.a_from_b, inverse(at(0)) @ at(2))
    assert registered.other_colors == 0.25
    assert matching.pairs == [registered]
    assert matching.quality[0].n_features == registered.n_features == 50


def test_a_pair_whose_registration_comes_to_nothing_is_none():
    matching = Told(lambda a, b: True)
    matching.measure([(0, 2), (0, 3)])
    matching.shares = lambda a, b: False
    assert matching.register(matching.pairs[0]) is None
    assert [pair.ends for pair in matching.pairs] == [(0, 3)]
    assert matching.unrecognised == {(0, 2)}


def test_what_was_compared_in_vain_is_told_from_what_others_tell_and_from_what_was_not_compared():
    matching = Told(lambda a, b: (a < 20) == (b < 20))
    asked = [(a, b) for a, b in combinations(range(N), 2) if b != 39]
    matching.measure(asked)
    assert matching.unrecognised == {(a, b) for a, b in asked if a < 20 <= b}
    assert len(matching.pairs) < len(asked) - len(matching.unrecognised)  # of the others some were left out
