"""How far apart pictures can lie that follow each other, how the camera turned, and what comes of knowing it."""

from __future__ import annotations

from dataclasses import replace
from itertools import pairwise
from types import SimpleNamespace

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from data_tools import open_sequence
from razer.metrics.scene_pair import TimedPoses
from razer.metrics.trajectory_errors import trajectory_metrics
from slam.config import SlamConfig
from slam.pose_edge import PoseEdge
from slam.se3 import exp_se3
from slam.sparse.camera_motion import SLACK_M, TIMES_FASTEST, CameraSpeed, steadiness, turning_rad_s
from slam.sparse.known_pairs import KnownPairs
from slam.sparse.measured_pair import MeasuredPair
from slam.sparse.placement.parts import Parts
from slam.sparse.sparse_system import SparseSystem

STAMPS = [0.0, 1.0, 2.0, 4.0, 4.0]  # the last two of one moment: these are no times
FASTEST = 0.6  # metres a second
AXIS = np.array([0.6, 0.0, 0.8])


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


def test_where_pictures_between_are_in_neither_set_there_was_as_much_more_time(speed):
    reach_m = TIMES_FASTEST * FASTEST * 2.0 + SLACK_M
    assert not speed.is_exceeded({0: at(0.0)}, {2: at(reach_m - 0.01)})
    assert speed.is_exceeded({0: at(0.0)}, {2: at(reach_m + 0.01)})
    assert not speed.is_exceeded({0: at(0.0), 1: at(reach_m)}, {2: at(reach_m + 0.01)})  # one is at hand


def test_where_a_picture_lies_in_the_other_set_does_not_count(speed):
    there = {0: at(0.0), 1: at(99.0), 2: at(0.0)}
    assert not speed.is_exceeded({1: at(0.0)}, there)
    assert speed.is_exceeded({1: at(99.0)}, there | {1: at(0.0)})


def test_nothing_is_said_within_a_set_or_without_times(make_speed, speed):
    assert not speed.is_exceeded({0: at(0.0), 1: at(99.0)}, {2: at(99.0), 3: at(0.0)})
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


def turned(rad):
    return exp_se3(np.concatenate([rad * AXIS, [0.3, 0.1, 0.0]]))


def told(stamps, *edges):
    """By edges (a, b, radians)."""
    keyframes = [SimpleNamespace(view=SimpleNamespace(stamp=stamp)) for stamp in stamps]
    return turning_rad_s(keyframes, [PoseEdge(a, b, turned(rad), np.eye(6)) for a, b, rad in edges])


def test_a_camera_turns_as_from_the_one_before_and_to_the_one_after():
    turning = told([0.0, 0.1, 0.3], (0, 1, 0.1), (1, 2, 0.1))
    assert turning.keys() == {0, 1, 2}
    for number, rad_s in enumerate((1.0, 0.75, 0.5)):
        np.testing.assert_allclose(turning[number], rad_s * AXIS, atol=1e-9)


def test_it_is_about_the_axes_of_either_camera():
    """A world axis that both turn about is the same for both."""
    world_from_a = Rotation.from_rotvec([0.4, -0.2, 1.0]).as_matrix()
    world_from_b = Rotation.from_rotvec(0.2 * AXIS).as_matrix() @ world_from_a
    a_from_b = np.eye(4)
    a_from_b[:3, :3] = world_from_a.T @ world_from_b
    keyframes = [SimpleNamespace(view=SimpleNamespace(stamp=stamp)) for stamp in (0.0, 0.2)]
    turning = turning_rad_s(keyframes, [PoseEdge(0, 1, a_from_b, np.eye(6))])
    for number, rotation in enumerate((world_from_a, world_from_b)):
        np.testing.assert_allclose(rotation @ turning[number], AXIS, atol=1e-9)


@pytest.mark.parametrize(
    ("gap_s", "rad"),
    [(0.0, 0.01), (0.001, 0.01), (0.6, 0.1), (0.1, 0.7)],
    ids=["one moment", "no times", "too long", "too fast"],
)
def test_nothing_is_told_of(gap_s, rad):
    assert told([1.0, 1.0 + gap_s], (0, 1, rad)) == {}


def steps(*angles_rad):
    """Between pictures that look along such angles about one axis."""
    return [PoseEdge(n, n + 1, turned(b - a), np.eye(6)) for n, (a, b) in enumerate(pairwise(angles_rad))]


def test_a_camera_that_goes_on_to_turn_is_steady_and_pictures_in_no_order_are_not():
    assert steadiness(steps(0.0, 0.1, 0.2, 0.5)) == pytest.approx(1.0)
    assert steadiness(steps(0.0, 0.3, 0.0, 0.3)) == pytest.approx(0.0)
    assert steadiness(steps(0.0, 0.1, 0.4, 0.3)) == pytest.approx((0.4 + 0.2) / (0.4 + 0.4))
    anywhere = np.random.default_rng(3).uniform(0, 1, 4000)
    assert steadiness(steps(*anywhere)) == pytest.approx(0.5, abs=0.02)


def test_steps_that_do_not_follow_each_other_say_nothing_of_an_order():
    back_and_forth = steps(0.0, 0.3, 0.0, 0.3, 0.0)
    assert steadiness(back_and_forth[::2]) == 1.0
    assert steadiness([]) == 1.0


def test_of_pictures_in_no_order_no_turning_is_told():
    stamps = np.arange(50) / 10
    angles = 0.05 * np.arange(50)
    assert len(told(stamps, *((e.a, e.b, 0.05) for e in steps(*angles)))) == 50
    shuffled = np.random.default_rng(3).permutation(angles)
    assert told(stamps, *((n, n + 1, b - a) for n, (a, b) in enumerate(pairwise(shuffled)))) == {}


def timed(poses, shots):
    return TimedPoses(np.array([shots[n].stamp for n in sorted(poses)]), np.stack([poses[n] for n in sorted(poses)]))


def test_pictures_of_a_camera_that_turns_fast_are_as_exact_as_of_one_that_is_followed(real_data):
    """Every third frame of freiburg1_rpy: as if it had not turned 4.7 cm and 2.5 degrees."""
    clip = open_sequence(real_data / "tum_fr1_rpy_head")
    shots = [clip[n] for n in range(0, len(clip), 3)]
    system = SparseSystem()
    for n, shot in enumerate(shots):
        system.locate(replace(shot, index=n, world_from_camera=None))
    system.finish()
    poses = system.trajectory()
    assert len(poses) == len(shots)
    errors = trajectory_metrics(timed({n: shot.pose for n, shot in enumerate(shots)}, shots), timed(poses, shots))
    assert errors.ate_rmse_m < 0.02
    assert errors.rotation_rmse_deg < 1.5
