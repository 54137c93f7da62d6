"""What a crop shows where colour comes from a camera beside the depth camera."""

from __future__ import annotations

import numpy as np

from app.query.view_crops import crop_of
from data_tools.recordings.color_warp import ColorWarp
from data_tools.recordings.rgbd_calibration import RgbdCalibration
from razer.frame import Frame, Intrinsics

CAMERA = Intrinsics(80, 60, 60.0, 60.0, 39.5, 29.5)
BASELINE_M = 0.05
NEAR = (slice(20, 40), slice(30, 50))  # the box x 30, y 20, 20 by 20
BOX = (30, 20, 20, 20)


def test_a_crop_is_cut_from_the_picture_as_it_was_recorded():
    depth = np.full((60, 80), 2.0, np.float32)
    depth[NEAR] = 1.0
    rgb = np.full((60, 80, 3), 90, np.uint8)
    rgb[20:40, 27:47] = (255, 0, 0)  # 60 * 0.05 / 1.0 to the left
    color_from_depth = np.eye(4)
    color_from_depth[0, 3] = -BASELINE_M
    warp = ColorWarp.between(CAMERA, RgbdCalibration(CAMERA, color_from_depth))
    frame = warp.registered(Frame(0, 0.0, rgb, depth, CAMERA))
    crop = crop_of(frame, BOX)
    assert crop.shape == (26, 26, 3)  # the square, and a margin of 3 pixels
    assert (crop[3:-3, 3:-3] == (255, 0, 0)).all()
    assert (crop[:3] == 90).all()
    assert (crop > 0).any(axis=2).all(), "it has no black seam"


def test_without_another_picture_the_frame_itself_is_cut():
    rgb = np.arange(60 * 80 * 3, dtype=np.uint32).reshape(60, 80, 3).astype(np.uint8)
    frame = Frame(0, 0.0, rgb, np.ones((60, 80), np.float32), CAMERA)
    np.testing.assert_array_equal(crop_of(frame, (0, 0, 10, 20)), rgb[0:23, 0:12])


def test_of_what_the_colour_camera_does_not_see_the_box_stays():
    depth = np.full((60, 80), 2.0, np.float32)
    color_from_depth = np.eye(4)
    color_from_depth[2, 3] = -10.0  # all of it lies behind the colour camera
    warp = ColorWarp.between(CAMERA, RgbdCalibration(CAMERA, color_from_depth))
    frame = warp.registered(Frame(0, 0.0, np.full((60, 80, 3), 7, np.uint8), depth, CAMERA))
    assert crop_of(frame, BOX).shape == (26, 26, 3)
