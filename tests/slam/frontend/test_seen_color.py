"""Colour that a camera beside the depth camera does not see: its outline is no texture."""

from __future__ import annotations

import cv2
import numpy as np
import pytest

from razer.frame import Frame, Intrinsics
from slam.config import SlamConfig
from slam.frontend.color_calibration import ColorCalibration
from slam.frontend.features import FeatureExtractor
from slam.frontend.seen_color import BESIDE_PX, seen_gray
from slam.frontend.wide_features import WideFeatures

CAMERA = Intrinsics(640, 480, 525.0, 525.0, 319.5, 239.5)
CONFIG = SlamConfig()
NOMINAL = ColorCalibration.nominal()


def frame_of(rgb, has_color):
    depth = np.full((480, 640), 2.0, np.float32)
    return Frame(0, 0.0, np.where(has_color[..., None], rgb, 0).astype(np.uint8), depth, CAMERA, has_color=has_color)


@pytest.fixture
def shadows(rng):
    """Where the colour camera sees: not in a dozen boxes, which stand in the shadow of something."""
    has_color = np.ones((480, 640), bool)
    for row, column in rng.integers((20, 20), (400, 560), (12, 2)).tolist():
        has_color[row : row + 50, column : column + 40] = False
    return has_color


def pixels(features):
    return np.rint(features.rays * (CAMERA.fx, CAMERA.fy) + (CAMERA.cx, CAMERA.cy)).astype(int)


def both(frame):
    return FeatureExtractor(CONFIG).extract(frame, NOMINAL), WideFeatures(frame, NOMINAL, CONFIG).features


def test_a_bare_wall_has_no_features_where_it_is_not_seen(shadows):
    for features in both(frame_of(np.full((480, 640, 3), 150), shadows)):
        assert len(features) == 0


def test_of_texture_all_is_found_but_what_lies_beside_shadows(shadows, rng):
    texture = np.kron(rng.integers(30, 220, (60, 80, 3)), np.ones((8, 8, 1)))
    whole = both(frame_of(texture, np.ones_like(shadows)))
    for features, of_whole in zip(both(frame_of(texture, shadows)), whole, strict=True):
        away = cv2.distanceTransform(shadows.astype(np.uint8), cv2.DIST_L2, cv2.DIST_MASK_PRECISE)
        column, row = pixels(features).T
        assert away[row, column].min() > BESIDE_PX - 2  # a pixel of a reduced image is that wide
        assert len(features) > 0.6 * len(of_whole)


def test_what_is_not_seen_is_as_grey_as_what_is_beside_it():
    has_color = np.ones((480, 640), bool)
    has_color[100:200, 300:340] = False
    rgb = np.zeros((480, 640, 3)) + np.where(np.arange(640) < 320, 60, 200)[:, None]
    gray, corners = seen_gray(frame_of(rgb, has_color))
    assert set(np.unique(gray).tolist()) == {60, 200}
    assert (gray[150, 302], gray[150, 338]) == (60, 200)
    assert not corners[95:205, 295:345].any()
    assert corners[:90].all()


def test_where_all_is_seen_or_nothing_is_known_corners_may_lie_anywhere_and_where_nothing_is_nowhere():
    rgb, everywhere = np.full((480, 640, 3), 90), np.ones((480, 640), bool)
    assert seen_gray(frame_of(rgb, everywhere))[1] is None
    unknown = Frame(0, 0.0, rgb.astype(np.uint8), np.ones((480, 640), np.float32), CAMERA)
    assert seen_gray(unknown)[1] is None
    assert not seen_gray(frame_of(rgb, ~everywhere))[1].any()
