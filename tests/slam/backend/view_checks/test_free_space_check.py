"""What two views contradict each other in."""

from __future__ import annotations

import numpy as np
import pytest

from razer.frame import Frame, Intrinsics
from slam.backend.view_checks.free_space_check import contradiction
from slam.config import SlamConfig
from slam.frontend.color_calibration import ColorCalibration
from slam.frontend.features import FeatureExtractor
from slam.frontend.keyframes import STILL, View

CAMERA = Intrinsics(320, 240, 260.0, 260.0, 159.5, 119.5)
CONFIG = SlamConfig()


def shift(z_m):
    result = np.eye(4)
    result[2, 3] = z_m
    return result


def corridor(end_m, half_m=1.0):
    """The depth of a square corridor along the camera's axis that ends after some metres."""
    rows, columns = np.mgrid[0:240, 0:320]
    slant = np.maximum(np.abs((columns - 159.5) / 260.0), np.abs((rows - 119.5) / 260.0))
    return np.minimum(half_m / np.maximum(slant, 1e-9), end_m).astype(np.float32)


def view(depth):
    frame = Frame(0, 0.0, np.zeros((240, 320, 3), np.uint8), depth, CAMERA)
    features = FeatureExtractor(CONFIG).extract(frame, ColorCalibration.nominal())
    return View.of(frame, features, STILL, CONFIG)


def test_two_true_views_do_not_contradict_each_other():
    assert contradiction(view(corridor(8.0)), view(corridor(6.0)), shift(2.0), CONFIG.free_space) == 0.0


def test_a_corridor_gives_itself_away_by_its_end_beyond_the_reach_of_registration():
    # Walls, floor and ceiling agree at any shift along the corridor; its end, 6 m away, agrees at one only.
    along = contradiction(view(corridor(8.0)), view(corridor(6.0)), shift(0.0), CONFIG.free_space)
    true_share = np.mean(corridor(6.0) == 6.0)
    assert along == pytest.approx(true_share, rel=0.25)
    # Where the submap would stand too far back, it is the other view that contradicts.
    assert contradiction(view(corridor(6.0)), view(corridor(8.0)), shift(0.0), CONFIG.free_space) == pytest.approx(
        along
    )


def test_what_drift_may_have_moved_does_not_contradict():
    views = view(corridor(8.0)), view(corridor(6.0))
    assert contradiction(*views, shift(0.0), CONFIG.free_space, drift_m=1.5) > 0
    assert contradiction(*views, shift(0.0), CONFIG.free_space, drift_m=2.0) == 0.0


def test_what_was_not_read_contradicts_nothing():
    holes = corridor(8.0)
    holes[holes > 6.0] = 0.0
    assert contradiction(view(holes), view(corridor(6.0)), np.eye(4), CONFIG.free_space) == 0.0


def post(column):
    """The depth of a post before a far wall, and its view by a camera that stood still."""
    depth = np.full((240, 320), 4.0, np.float32)
    depth[:, column : column + 32] = 1.5
    return view(depth)


def test_depth_that_lags_behind_a_turning_camera_contradicts_nothing():
    """A post of 8 pixels that depth shows 3 pixels beside where colour has it: of a camera that turned by a radian a
    second, 0.05 s of which are as much, it may be the same post; of one that stood still it is another."""
    here, beside = post(100), post(112)
    assert contradiction(here, beside, np.eye(4), CONFIG.free_space) > 0.02
    for turning in (here.turning(np.array([0.0, 1.2, 0.0])), beside), (here, beside.turning(np.array([0.0, 0.0, 1.2]))):
        assert contradiction(*turning, np.eye(4), CONFIG.free_space) == 0.0
    elsewhere = post(200)
    assert contradiction(
        here.turning(np.array([0.0, 1.2, 0.0])), elsewhere, np.eye(4), CONFIG.free_space
    ) == pytest.approx(0.1)
