"""How far apart pictures can lie that follow each other."""

from __future__ import annotations

from types import SimpleNamespace

import numpy as np
import pytest

from slam.config import SlamConfig
from slam.pose_edge import PoseEdge
from slam.sparse.camera_speed import SLACK_M, TIMES_FASTEST, CameraSpeed
from slam.sparse.known_pairs import KnownPairs
from slam.sparse.measured_pair import MeasuredPair
from slam.sparse.parts import Parts

STAMPS = [0.0, 1.0, 2.0, 4.0, 4.0]  # the last two of one moment: these are no times
FASTEST = 0.6  # metres a second


def at(x):
    pose = np.eye(4)
    pose[0, 3] = x
    return pose


def pair(a, b, way_m, is_next=True, n_features=50):
    return MeasuredPair(PoseEdge(a, b, at(way_m), 1e6 * np.eye(6)), n_features, 0.5, is_next=is_next)


@pytest.fixture
def make_speed():
    keyframes = [SimpleNamespace(view=SimpleNamespace(stamp=stamp)) for stamp in STAMPS]
    return lambda pairs: CameraSpeed(keyframes, pairs)


@pytest.fixture
def speed(make_speed):
    return make_speed([pair(0, 1, 0.5), pair(1, 2, FASTEST), pair(3, 4, 9.0), pair(0, 4, 50.0, is_next=False)])


def test_the_fastest_is_that_of_pictures_that_follow_each_other(make_speed, speed):
    assert speed.fastest_m_per_s == pytest.approx(FASTEST)
    assert make_speed([pair(0, 1, 0.5, is_next=False)]).fastest_m_per_s == np.inf


@pytest.mark.parametrize(("a", "b", "gap_s"), [(1, 2, 1.0), (2, 1, 1.0), (3, 2, 2.0)])
def test_what_follows_lies_within_reach(speed, a, b, gap_s):
    reach_m = TIMES_FASTEST * FASTEST * gap_s + SLACK_M
    assert not speed.is_exceeded({a: at(0.0)}, {b: at(reach_m - 0.01)})
    assert speed.is_exceeded({a: at(0.0)}, {b: at(reach_m + 0.01)})
    assert speed.is_exceeded({0: at(0.0), a: at(0.0)}, {b: at(-reach_m - 0.01)})


def test_nothing_is_said_of_pictures_that_do_not_follow_each_other_or_without_times(make_speed, speed):
    assert not speed.is_exceeded({0: at(0.0)}, {2: at(99.0), 3: at(99.0)})
    assert not speed.is_exceeded({3: at(0.0)}, {4: at(99.0)})
    assert not make_speed([]).is_exceeded({0: at(0.0)}, {1: at(99.0)})


class NothingShared(Parts):
    """Parts of pictures none of which shows what another does, so that space says nothing."""

    def _near_pairs(self, home, moved):
        return []


@pytest.mark.parametrize(("in_order", "away_m"), [(True, 1.5), (False, 20.0)])
def test_a_carried_camera_is_at_no_look_alike_far_off_a_moment_later(in_order, away_m):
    """Two stretches of a walk, half a metre a second, and sure ties that have the second one lie 20 m off."""
    keyframes, config = [SimpleNamespace(view=SimpleNamespace(stamp=float(n))) for n in range(6)], SlamConfig()
    along = [pair(a, a + 1, 0.5, in_order) for a in (0, 1, 3, 4)]
    across = [pair(2, 3, 0.5, False, 13)]
    false = [pair(a, a + 3, 20.0, False, 90) for a in (0, 1)]
    parts = NothingShared(keyframes, KnownPairs(keyframes, [*along, *across, *false], config), config)
    parts.grow()
    assert parts.part_of[0] == parts.part_of[3]
    assert parts.poses[3][0, 3] - parts.poses[0][0, 3] == pytest.approx(away_m, abs=0.1)
