"""What moved since earlier keyframes is not kept; what stands, and what other odometry saw, is."""

from __future__ import annotations

import numpy as np
import pytest

from razer.frame import Frame, Intrinsics
from slam.backend.dynamic_masking import DynamicMasking
from slam.config import SlamConfig
from slam.frontend.color_calibration import ColorCalibration
from slam.frontend.features import FeatureExtractor
from slam.frontend.keyframes import STILL, Keyframes, View

CAMERA = Intrinsics(320, 240, 260.0, 260.0, 159.5, 119.5)
CONFIG = SlamConfig()
WALL_M, PERSON_M = 3.0, 2.0
HERE = np.eye(4)
PERSON = slice(80, 240), slice(120, 180)  # rows and columns


def view_of(person_m: float | None) -> View:
    """Before a wall with features everywhere; somebody stands before it."""
    depth = np.full((240, 320), WALL_M, np.float32)
    if person_m is not None:
        depth[PERSON] = person_m
    rgb = np.kron(np.random.default_rng(3).integers(0, 255, (30, 40, 3)), np.ones((8, 8, 1))).astype(np.uint8)
    frame = Frame(0, 0.0, rgb, depth, CAMERA)
    return View.of(frame, FeatureExtractor(CONFIG).extract(frame, ColorCalibration.nominal()), STILL, CONFIG)


def static_part(earlier: View, view: View, travelled_m: float = 0.0) -> View:
    keyframes = Keyframes()
    before = keyframes.add(earlier, HERE, 0, 0.0)
    return DynamicMasking(keyframes, CONFIG).static_part(view, before, HERE, travelled_m)


@pytest.fixture(scope="module")
def empty() -> View:
    return view_of(None)


def test_who_came_since_is_left_out_and_nothing_else(empty):
    view = view_of(PERSON_M)
    static = static_part(empty, view)
    depth, before = static.pyramid.depth, view.pyramid.depth
    assert not (depth == PERSON_M).any()
    assert (before == PERSON_M).sum() < ((before > 0) & (depth == 0)).sum() < 1.5 * (before == PERSON_M).sum()
    assert np.array_equal(depth[depth > 0], before[depth > 0])
    assert not (static.features.depth_m == PERSON_M).any()
    assert 0.5 * len(view.features) < len(static.features) < len(view.features)
    assert not (static.wide.features.depth_m == PERSON_M).any()
    assert not (static.sparse.depth == PERSON_M).any()


def test_what_stood_there_before_and_what_went_away_are_kept(empty):
    standing = view_of(PERSON_M)
    assert static_part(view_of(PERSON_M), standing) is standing
    assert static_part(standing, empty) is empty


def test_what_lies_no_farther_off_than_the_camera_may_have_drifted_is_kept(empty):
    near = view_of(WALL_M - 0.3)
    assert static_part(empty, near) is not near
    far_m = 0.3 / CONFIG.loop_closure.drift_m_per_m
    assert static_part(empty, near, far_m) is near


def test_keyframes_of_other_odometry_mask_nothing():
    came = view_of(PERSON_M)
    keyframes = Keyframes()
    keyframes.add(view_of(None), HERE, 0, 0.0, chain=0)
    before = keyframes.add(view_of(PERSON_M), HERE, 1, 0.0, chain=1)
    assert DynamicMasking(keyframes, CONFIG).static_part(came, before, HERE, 0.0) is came


def test_a_keyframe_of_which_hardly_anything_would_be_left_is_kept_whole(empty):
    """Somebody before the lens: without him nothing could follow it."""
    everywhere = Frame(0, 0.0, np.zeros((240, 320, 3), np.uint8), np.full((240, 320), 1.0, np.float32), CAMERA)
    everywhere.depth[:, :16] = WALL_M
    features = FeatureExtractor(CONFIG).extract(everywhere, ColorCalibration.nominal())
    view = View.of(everywhere, features, STILL, CONFIG)
    assert static_part(empty, view) is view
