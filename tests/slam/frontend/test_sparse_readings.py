"""Sparse readings, whose colours are those that another camera saw there."""

from __future__ import annotations

import numpy as np
import pytest

from razer.frame import Frame, Intrinsics
from slam.config import SlamConfig
from slam.frontend.color_calibration import NOMINAL, ColorCalibration
from slam.frontend.features import FeatureExtractor
from slam.frontend.keyframes import STILL, Keyframes, View

CAMERA = Intrinsics(640, 480, 525.0, 525.0, 319.5, 239.5)
CONFIG = SlamConfig()
WALL_M = 2.0


def lens(**changed):
    """A colour camera that is known to differ so much from the nominal one: scale, x, y or baseline."""
    parameters = NOMINAL.copy()
    for name, value in changed.items():
        parameters[{"scale": 0, "x": 3, "y": 4, "baseline": 5}[name]] = value
    return ColorCalibration(parameters, np.eye(7))


def ramp(rays):
    """Colours (..., 3) of what lies along rays (..., 2) on the wall: smooth, as they are read between pixels, too."""
    x, y = rays[..., 0], rays[..., 1]
    return np.stack([128 + 120 * x, 128 + 150 * y, 128 + 50 * (x - y)], axis=-1)


def pixel_rays(k):
    row, column = np.indices((k.height, k.width))
    return np.stack([(column - k.cx) / k.fx, (row - k.cy) / k.fy], axis=-1)


def seen_through(camera, calibration=None):
    """The view of a wall whose colours a camera saw on the grid of depth, made with what is known of that camera."""
    rays = pixel_rays(CAMERA)
    there = camera.depth_rays(rays.reshape(-1, 2), np.full(rays[..., 0].size, WALL_M)).reshape(rays.shape)
    depth = np.full(there.shape[:2], WALL_M, np.float32)
    frame = Frame(0, 0.0, np.rint(ramp(there).clip(0, 255)).astype(np.uint8), depth, CAMERA)
    features = FeatureExtractor(CONFIG).extract(frame, ColorCalibration.nominal())
    return View.of(frame, features, STILL, CONFIG, calibration)


def off(view):
    """By how many grey levels the colours (n, 3) of a view that the camera saw differ from those of the wall there."""
    return np.abs(view.sparse.rgb - ramp(pixel_rays(view.sparse.intrinsics)))[view.sparse.has_color]


@pytest.mark.parametrize("camera", [lens(scale=1.1), lens(scale=0.9), lens(x=0.05, y=-0.04), lens(baseline=-0.06)])
def test_readings_have_the_colours_that_the_camera_saw_there(camera):
    assert off(seen_through(camera)).max() > 4
    assert off(seen_through(camera, camera)).max() < 2


def test_what_the_colour_camera_did_not_see_has_no_colour():
    narrow = lens(scale=0.8)
    view = seen_through(narrow, narrow)
    rays = pixel_rays(view.sparse.intrinsics)
    inside = (np.abs(rays) < 0.79 * np.array([319.5, 239.5]) / 525).all(axis=2)
    outside = (np.abs(rays) > 0.82 * np.array([319.5, 239.5]) / 525).any(axis=2)
    assert view.sparse.has_color[inside].all()
    assert not view.sparse.has_color[outside].any()
    assert seen_through(lens()).sparse.has_color.all()


def test_colours_stay_as_they_are_for_a_camera_that_is_off_by_little():
    camera = lens(scale=1.005)
    view = seen_through(camera, camera)
    assert view.sparse.rgb is view.sparse.recorded_rgb


def test_keyframes_are_seen_anew_once_the_camera_is_known():
    camera, keyframes = lens(scale=1.1, baseline=0.03), Keyframes()
    for _ in range(2):
        keyframes.add(seen_through(camera), np.eye(4), 0, 0.0)
    before = keyframes[0].view
    keyframes.recolor(lens(scale=1.004))
    assert keyframes[0].view is before
    keyframes.recolor(camera)
    for keyframe in keyframes.all:
        assert off(keyframe.view).max() < 2
    again = keyframes[1].view
    keyframes.recolor(camera)
    assert keyframes[1].view is again
    keyframes.recolor(ColorCalibration.nominal())
    np.testing.assert_array_equal(keyframes[0].view.sparse.rgb, before.sparse.rgb)


def test_no_keyframe_is_no_error():
    Keyframes().recolor(lens(scale=1.2))


def test_readings_that_the_colour_camera_did_not_see_have_no_colour():
    """It stands beside, and sees the left two thirds: what is black there is no colour, wherever colours are read."""
    has_color = np.zeros((480, 640), bool)
    has_color[:, :400] = True
    rgb = np.where(has_color[..., None], np.rint(ramp(pixel_rays(CAMERA))), 0).clip(0, 255).astype(np.uint8)
    frame = Frame(0, 0.0, rgb, np.full((480, 640), WALL_M, np.float32), CAMERA, has_color=has_color)
    view = View.of(frame, FeatureExtractor(CONFIG).extract(frame, ColorCalibration.nominal()), STILL, CONFIG)
    assert off(view).max() < 4
    assert 0.55 < view.sparse.has_color.mean() <= 0.625
    moved = view.recolored(lens(x=0.2))
    assert (moved.sparse.has_color & ~view.sparse.has_color).any()
    assert off(view.recolored(lens(x=0.2)).recolored(ColorCalibration.nominal())).max() < 4
    assert moved.sparse.rgb[moved.sparse.has_color].min() > 0
