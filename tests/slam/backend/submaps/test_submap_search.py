"""What a view of an unanchored submap is compared with next."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from razer.frame import Frame, Intrinsics
from slam.backend.submaps.local_map import Recognised
from slam.backend.submaps.submap_search import Candidate, SubmapSearch
from slam.config import SlamConfig
from slam.frontend.color_calibration import ColorCalibration
from slam.frontend.features import FeatureExtractor
from slam.frontend.icp import IcpResult
from slam.frontend.keyframes import STILL, Keyframes, LocatedView, View
from slam.frontend.rigid_matches import RigidMotion
from slam.se3 import exp_se3

NOMINAL = ColorCalibration.nominal()
WALL = Frame(
    0,
    0.0,
    np.full((120, 160, 3), 90, np.uint8),
    np.full((120, 160), 2.0, np.float32),
    Intrinsics(160, 120, 130.0, 130.0, 79.5, 59.5),
)
VIEW = View.of(WALL, FeatureExtractor(SlamConfig()).extract(WALL, NOMINAL), STILL, SlamConfig())
RESULT = IcpResult(np.eye(4), np.eye(6), np.eye(6), 0.5, 0.9, 0.4, 0.5, 30, NOMINAL)


def shifted(x_m):
    pose = np.eye(4)
    pose[0, 3] = x_m
    return pose


LED_TO, ALIKE = Candidate(7, np.eye(4), is_foreseen=True), [Candidate(n, np.eye(4)) for n in (1, 2, 3)]


@pytest.fixture
def search(monkeypatch):
    monkeypatch.setattr(SubmapSearch, "candidates", lambda _, places, shortlist: places)
    return SubmapSearch(None, None, None, None, None, SlamConfig())


def test_places_that_look_alike_are_asked_in_turn_and_those_that_hypotheses_lead_to_always(search):
    asked = [[one.number for one in search.next_candidates([LED_TO, *ALIKE])] for _ in range(6)]
    assert all(numbers[0] == 7 and len(numbers) == 2 for numbers in asked)
    assert [numbers[1] for numbers in asked[3:]] == [numbers[1] for numbers in asked[:3]]
    assert {numbers[1] for numbers in asked} == {1, 2, 3}


def test_where_nothing_looks_alike_nothing_is_asked(search):
    assert search.next_candidates([]) == []
    assert search.next_candidates([LED_TO]) == [LED_TO]


class World:
    """Keyframes of submap 0 that look alike, and what features and registrations say of a view of submap 1."""

    def __init__(self, explained, alone=(), together=True, foreseen=()):
        self.explained, self.alone, self.together, self.foreseen = explained, alone, together, foreseen
        self.keyframes, self.asked_alone, self.asked_together = Keyframes(), [], []
        for n in range(len(explained)):
            self.keyframes.add(replace(VIEW, index=n), shifted(10.0 * n), 0, 0.0)  # too far apart for one place
        reference = self.keyframes.add(replace(VIEW, index=99), np.eye(4), 1, 0.0)
        self.located = LocatedView(VIEW, reference, np.eye(4))
        self.search = SubmapSearch(self.keyframes, self, self, self, self, SlamConfig())

    def expected(self, submap):
        return [(0, motion) for motion in self.foreseen]

    def lookalikes(self, view, numbers, *_):
        return [n for n in numbers.tolist() if n < len(self.explained)]

    def rigid_motion(self, keyframe, view, hints):
        n, is_sure = self.explained[keyframe.number], self.explained[keyframe.number] >= 8
        return RigidMotion(shifted(0.1), n, np.eye(6), is_sure) if n >= 4 and (is_sure or hints) else None

    def recognise(self, where, view, *arguments):
        """A stub of both: alone, in front of a keyframe, and together, in a submap near a pose."""
        if isinstance(where, int):
            self.asked_together.append(float(arguments[0][0, 3]))
            return Recognised(0, RESULT) if self.together else None
        self.asked_alone.append(where.number)
        return RESULT if where.number in self.alone else None

    def candidates(self):
        return self.search.candidates(self.located, 3)

    def recognised(self):
        return [edge.a for edge, _ in self.search.recognised(self.located, self.candidates(), NOMINAL)]


def test_sure_motions_are_asked_alone_those_of_most_features_first():
    world = World([9, 20, 5, 12, 0], alone=(0, 1, 3))
    assert world.recognised() == [1, 3, 0]
    assert world.asked_together == []


def test_a_place_that_few_features_lead_to_is_asked_for_together_if_there_is_no_other():
    world = World([5, 7, 0])
    assert world.recognised() == [0]
    assert world.asked_alone == []
    assert world.asked_together == [pytest.approx(10.1)]  # in front of the one of most features
    assert World([5, 7, 9], alone=(2,)).recognised() == [2]


def test_what_one_keyframe_shows_too_little_of_is_asked_for_together():
    world = World([9, 0])
    assert world.recognised() == [0]
    assert world.asked_alone == [0]
    assert world.asked_together == [pytest.approx(0.1)]
    assert World([9, 0], together=False).recognised() == []


def test_hypotheses_lead_to_places_of_which_a_view_shows_little():
    """To one that sees a tenth of it and more; not to one that sees nothing."""
    aside = exp_se3(np.array([0, np.radians(35), 0, 0, 0, 0]))
    assert [one.is_foreseen for one in World([0], foreseen=[aside]).candidates()] == [True]
    away = exp_se3(np.array([0, np.radians(80), 0, 0, 0, 0]))
    assert World([0], foreseen=[away]).candidates() == []


def test_an_edge_to_a_keyframe_that_came_later_has_the_earlier_one_first():
    world = World([9, 20])
    later = world.keyframes.add(replace(VIEW, index=100), np.eye(4), 0, 0.0)
    world.alone = (later.number,)
    ((edge, _),) = world.search.recognised(world.located, [Candidate(later.number, np.eye(4))], NOMINAL)
    assert (edge.a, edge.b) == (world.located.reference.number, later.number)
