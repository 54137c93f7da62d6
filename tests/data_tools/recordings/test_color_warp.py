"""Colour looked up through depth: against a slow z-buffer, and a near square before a wall worked out by hand."""

from __future__ import annotations

import numpy as np
import pytest

from data_tools.recordings.color_warp import ColorWarp
from data_tools.recordings.rgbd_calibration import RgbdCalibration
from razer.arrays import BoolArray, Float32Array, Float64Array
from razer.frame import Frame, Intrinsics

CAMERA = Intrinsics(80, 60, 60.0, 60.0, 39.5, 29.5)
NEAR_M, FAR_M, BASELINE_M = 1.0, 3.0, 0.1
SQUARE = (slice(20, 40), slice(30, 50))


def beside(x_m: float) -> Float64Array:
    transform = np.eye(4)
    transform[0, 3] = -x_m
    return transform


def square() -> Float32Array:
    depth = np.full((60, 80), FAR_M, np.float32)
    depth[SQUARE] = NEAR_M
    return depth


def columns() -> np.ndarray:
    """Each pixel says its column (red) and row (green), none is black."""
    v, u = np.mgrid[:60, :80]
    return np.stack([u + 50, v + 50, np.full_like(u, 200)], axis=-1).astype(np.uint8)


def test_colour_is_that_of_the_projected_point() -> None:
    warp = ColorWarp.between(CAMERA, RgbdCalibration(CAMERA, beside(BASELINE_M)))
    color = warp.apply(columns(), square())
    near_px, far_px = 60 * BASELINE_M / NEAR_M, 60 * BASELINE_M / FAR_M  # 6 and 2 to the left
    assert (color.rgb[30, 30:50, 0] == np.arange(30, 50) + 50 - near_px).all()
    assert (color.rgb[5, 10:70, 0] == np.arange(10, 70) + 50 - far_px).all()
    assert (color.rgb[5, 10:70, 1] == 55).all()


def test_what_the_near_thing_hides_has_no_colour() -> None:
    """The square covers columns 24 to 43 of colour, where the wall's columns 26 to 45 are seen: those of them that
    depth sees, 26 to 29, are hidden."""
    warp = ColorWarp.between(CAMERA, RgbdCalibration(CAMERA, beside(BASELINE_M)))
    color = warp.apply(columns(), square())
    row = color.is_seen[30]
    assert not row[27:30].any()
    assert row[3:25].all()
    assert row[30:].all()
    assert not row[:2].any()  # outside of the colour image
    assert color.is_seen[5, 2:].all()
    assert (color.rgb[~color.is_seen] == 0).all()
    assert (color.rgb[color.is_seen] > 0).all()


def slow_visibility(depth: Float32Array, calibration: RgbdCalibration) -> BoolArray:
    """Whether a point is in the colour image, and not clearly behind another that projects within one and a half pixels
    of it; False = no, True = yes, by comparing all points with all."""
    points = []
    for v in range(depth.shape[0]):
        for u in range(depth.shape[1]):
            ray = np.array([(u - CAMERA.cx) / CAMERA.fx, (v - CAMERA.cy) / CAMERA.fy, 1.0]) * depth[v, u]
            x, y, z = calibration.color_from_depth[:3, :3] @ ray + calibration.color_from_depth[:3, 3]
            color = calibration.color
            points.append((color.fx * x / z + color.cx, color.fy * y / z + color.cy, z))
    places = np.array(points)
    inside = (np.abs(places[:, 0] - 39.5) <= 40) & (np.abs(places[:, 1] - 29.5) <= 30)
    hidden = np.zeros(len(places), bool)
    for i, (x, y, z) in enumerate(points):
        close = (np.abs(places[:, :2] - (x, y)) < 1.5).all(axis=1)
        hidden[i] = (places[close, 2] < 0.9 * z).any()
    return (inside & ~hidden).reshape(depth.shape)


def test_visibility_against_all_pairs() -> None:
    color_camera = Intrinsics(80, 60, 64.0, 64.0, 41.0, 27.0)
    transform = beside(0.08)
    transform[1, 3] = 0.05
    calibration = RgbdCalibration(color_camera, transform)
    seen = ColorWarp.between(CAMERA, calibration).apply(columns(), square()).is_seen
    slow = slow_visibility(square(), calibration)
    assert (~slow).sum() > 30
    assert (seen != slow).mean() < 0.02  # at borders, by a pixel
    deep_inside = ~slow & ~np.roll(slow, 1, 1) & ~np.roll(slow, -1, 1) & ~np.roll(slow, 1, 0) & ~np.roll(slow, -1, 0)
    assert not seen[deep_inside].any()


@pytest.mark.parametrize("finer", [1, 2, 3, 5, 8])
def test_a_finer_colour_image_hides_as_much(finer: int) -> None:
    """What a coarse depth camera sees beside the square takes nothing of the square's red, however fine colour is."""
    color_camera = CAMERA.resized(80 * finer, 60 * finer)
    rgb = np.full((60 * finer, 80 * finer, 3), 90, np.uint8)
    rgb[20 * finer : 40 * finer, 24 * finer : 44 * finer] = (255, 0, 0)  # where the square is seen, 6 pixels aside
    warp = ColorWarp.between(CAMERA, RgbdCalibration(color_camera, beside(BASELINE_M)))
    color = warp.apply(rgb, square())
    wall = np.ones((60, 80), bool)
    wall[SQUARE] = False
    is_red = (color.rgb == (255, 0, 0)).all(axis=2)
    assert is_red[SQUARE].mean() > 0.9
    assert not (is_red & wall).any()


def test_pixels_without_depth_look_as_their_neighbours_do() -> None:
    depth = np.full((60, 80), FAR_M, np.float32)
    whole = ColorWarp.between(CAMERA, RgbdCalibration(CAMERA, beside(BASELINE_M))).apply(columns(), depth)
    depth[10:20, 10:30] = 0
    gap = ColorWarp.between(CAMERA, RgbdCalibration(CAMERA, beside(BASELINE_M))).apply(columns(), depth)
    np.testing.assert_array_equal(gap.rgb, whole.rgb)


def test_one_camera_leaves_colour_as_it_is() -> None:
    warp = ColorWarp.between(CAMERA, RgbdCalibration(CAMERA, np.eye(4)))
    frame = warp.registered(Frame(0, 0.0, columns(), square(), CAMERA))
    np.testing.assert_array_equal(frame.rgb, columns())
    assert frame.has_color is not None
    assert frame.has_color.all()
