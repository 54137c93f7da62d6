"""Which keyframe a camera is followed from where there are several round about, and what it is tied to then."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from razer.geometry import inverse
from slam.backend.keyframe_map import KeyframeMap
from slam.config import KeyframeSettings, SlamConfig
from slam.frontend.color_calibration import ColorCalibration
from slam.frontend.frame_tracker import NEARLY_THERE, keyframe_nearby
from slam.frontend.keyframes import Keyframes
from slam.frontend.view_registration import ViewRegistration
from slam.se3 import exp_se3, length_m

SETTINGS = KeyframeSettings(max_shift_m=0.2, max_angle_deg=10.0)
REACH_M, REACH_DEG = NEARLY_THERE * SETTINGS.max_shift_m, NEARLY_THERE * SETTINGS.max_angle_deg
NOMINAL = ColorCalibration.nominal()


def at(x_m=0.0, turned_deg=0.0):
    return exp_se3(np.array([0, np.radians(turned_deg), 0, 0, 0, 0])) @ exp_se3(np.array([0, 0, 0, x_m, 0, 0]))


def keyframes_at(view, poses, chains):
    keyframes = Keyframes()
    for pose, chain in zip(poses, chains, strict=True):
        keyframes.add(view, pose, 0, 0.0, chain)
    return keyframes


def number_near(keyframes, reference_from_camera, reference=0):
    found = keyframe_nearby(keyframes, keyframes[reference], reference_from_camera, SETTINGS)
    return None if found is None else found.number


def test_the_nearest_keyframe_is_the_one_that_a_camera_goes_on_from_for_longest(views):
    keyframes = keyframes_at(views[10], [at(), at(0.30), at(0.35), at(0.9)], [0] * 4)
    assert number_near(keyframes, at(0.31)) == 1
    assert number_near(keyframes, at(0.34)) == 2
    # From another one's point of view it is the same: where the camera is counts.
    assert number_near(keyframes, inverse(at(0.9)) @ at(0.34), reference=3) == 2


@pytest.mark.parametrize("share", [0.99, 1.01])
def test_what_is_too_far_to_go_on_from_for_long_is_left(views, share):
    is_near = share < 1
    for offset in (at(share * REACH_M), at(turned_deg=share * REACH_DEG)):
        keyframes = keyframes_at(views[10], [at(), at(0.5) @ offset], [0, 0])
        assert number_near(keyframes, at(0.5)) == (1 if is_near else None)


def test_of_two_that_are_near_the_lesser_share_of_the_way_counts(views):
    """Half of the allowed turning is nearer than nine tenths of the allowed shift, however few metres that are."""
    poses = [at(), at(0.5) @ at(0.9 * REACH_M), at(0.5) @ at(turned_deg=0.5 * REACH_DEG)]
    assert number_near(keyframes_at(views[10], poses, [0, 0, 0]), at(0.5)) == 2


def test_the_reference_itself_and_other_chains_are_none(views):
    assert number_near(keyframes_at(views[10], [at()], [0]), at(0.01)) is None
    assert number_near(keyframes_at(views[10], [at(), at(0.5)], [0, 1]), at(0.5)) is None
    assert number_near(keyframes_at(views[10], [at(0.5), at()], [0, 1]), at(0.5), reference=1) is None


@pytest.fixture
def three(views):
    """Keyframes 0, 1 and 2: the first two joined by tracking, and so are the last two; 2 shows what 0 does."""
    slam = KeyframeMap(SlamConfig())
    first = slam.begin_submap(views[10], 0.0)
    fits = ViewRegistration(SlamConfig()).register(views[10], views[12], [np.eye(4)], NOMINAL)
    second = slam.extend(first, views[12], fits, 0.1)
    back = replace(fits, target_from_source=inverse(fits.target_from_source))
    third = slam.extend(second, replace(views[10], index=14), back, 0.2)
    while len(slam._loops):
        slam.close_loops(NOMINAL)
    return slam, first, second, third


def queued(slam):
    return [pair[:2] for pair in slam._loops._waiting]


def test_keyframes_that_tracking_leads_between_are_measured_unless_they_are_joined(three):
    slam, first, second, third = three
    slam.graph.replace([edge for edge in slam.graph.edges if edge.is_odometry])
    slam._loops._queued.clear()
    assert slam.tie(third, first, np.eye(4))
    assert queued(slam) == [(0, 2)]
    slam._loops._waiting.clear()
    assert slam.tie(first, second, inverse(first.world_from_camera) @ second.world_from_camera)
    assert queued(slam) == []


@pytest.mark.parametrize("swapped", [False, True])
def test_a_motion_that_does_not_fit_ties_nothing(three, swapped):
    slam, first, _, third = three
    slam._loops._queued.clear()
    away = at(1.0)
    assert not (slam.tie(third, first, inverse(away)) if swapped else slam.tie(first, third, away))
    assert queued(slam) == []
    ahead = inverse(first.world_from_camera) @ third.world_from_camera
    assert slam.tie(third, first, inverse(ahead)) if swapped else slam.tie(first, third, ahead)
    assert length_m(ahead) < 0.01
