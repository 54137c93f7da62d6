"""Pairs that put pictures on each other which were not recognised: of a wall, from places beside each other."""

from __future__ import annotations

import numpy as np
import pytest

from razer.frame import Frame, Intrinsics
from slam.config import SlamConfig
from slam.frontend.color_calibration import ColorCalibration
from slam.frontend.features import FeatureExtractor
from slam.frontend.keyframes import STILL, Keyframes, View
from slam.pose_edge import PoseEdge
from slam.se3 import exp_se3
from slam.sparse.measured_pair import MeasuredPair
from slam.sparse.missing_pairs import missing_pairs

CONFIG = SlamConfig()
CAMERA = Intrinsics(320, 240, 260.0, 260.0, 159.5, 119.5)


def pair(a, b, *motion):
    """b lies so far from a: turned by three angles, and shifted."""
    return MeasuredPair(PoseEdge(a, b, exp_se3(np.array(motion, float)), np.eye(6)), 50, 0.5)


@pytest.fixture(scope="module")
def pictures():
    """Three of a wall, 2 m away."""
    frame = Frame(0, 0.0, np.full((240, 320, 3), 120, np.uint8), np.full((240, 320), 2.0, np.float32), CAMERA)
    view = View.of(frame, FeatureExtractor(CONFIG).extract(frame, ColorCalibration.nominal()), STILL, CONFIG)
    keyframes = Keyframes()
    for _ in range(3):
        keyframes.add(view, np.eye(4), 0, 0.0)
    return keyframes


def missing(pictures, *pairs, unrecognised=((0, 1),)):
    return missing_pairs(pictures, pairs, unrecognised, CONFIG.depth.max_depth_m)


def test_two_pairs_that_put_pictures_on_each_other_are_at_odds_where_these_were_not_recognised(pictures):
    to_left, to_right = pair(0, 2, 0, 0, 0, 0.3, 0, 0), pair(1, 2, 0, 0, 0, -0.3, 0, 0)
    assert missing(pictures, to_left, to_right) == {(0, 2): [(1, 2)], (1, 2): [(0, 2)]}
    assert missing(pictures, to_left, to_right, unrecognised=()) == {}  # they were not compared
    assert missing(pictures, to_left, unrecognised=[(0, 1), (1, 2)]) == {}


def test_the_direction_in_which_pairs_were_measured_does_not_matter(pictures):
    to_left, to_right = pair(2, 0, 0, 0, 0, -0.3, 0, 0), pair(1, 2, 0, 0, 0, -0.3, 0, 0)
    assert missing(pictures, to_left, to_right) == {(2, 0): [(1, 2)], (1, 2): [(2, 0)]}


@pytest.mark.parametrize(
    "motion",
    [
        (0, 0, 0, 2.0, 0, 0),  # that far aside they share a fifth
        (0, 0.9, 0, 0, 0, 0),  # turned that far nothing
        (0, 0, 0, 0, 0, -1.9),  # of the one, a twentieth is what the other shows
    ],
)
def test_pictures_that_share_little_or_lie_far_apart_need_not_be_recognised(pictures, motion):
    assert missing(pictures, pair(0, 2, *motion), pair(1, 2, *6 * [0])) == {}
