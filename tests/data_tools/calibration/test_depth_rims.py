"""Depth rims of a box before a wall: where they lie, what depth they have, where their normals point."""

from __future__ import annotations

import numpy as np

from data_tools.calibration.depth_rims import DepthRims, find_depth_rims
from razer.frame import Frame, Intrinsics

CAMERA = Intrinsics(160, 120, 100.0, 100.0, 80.0, 60.0)
TOP, BOTTOM, LEFT, RIGHT = 40, 80, 60, 110  # the box covers [40, 80) x [60, 110)


def box(shadow: bool = False) -> Frame:
    depth = np.full((120, 160), 3.0, np.float32)
    if shadow:  # beside the box the projector does not reach the wall
        depth[TOP:BOTTOM, LEFT - 5 : LEFT] = 0
    depth[TOP:BOTTOM, LEFT:RIGHT] = 1.5
    return Frame(0, 0.0, np.zeros((120, 160, 3), np.uint8), depth, CAMERA)


def pixels(rims: DepthRims) -> np.ndarray:
    return np.asarray(rims.rays * 100.0 + (80.0, 60.0))


def test_rims_lie_on_the_border_of_the_near_thing() -> None:
    for frame in (box(), box(shadow=True)):
        rims = find_depth_rims(frame)
        u, v = pixels(rims).T
        np.testing.assert_allclose(rims.inverse_depth, 1 / 1.5)
        left, right = np.abs(u - (LEFT - 0.5)) < 0.3, np.abs(u - (RIGHT - 0.5)) < 0.3
        top, bottom = np.abs(v - (TOP - 0.5)) < 0.3, np.abs(v - (BOTTOM - 0.5)) < 0.3
        on_border = left | right | top | bottom
        assert on_border.mean() > 0.9  # corners are round
        assert (rims.normals[left & ~top & ~bottom][:, 0] < -0.7).all()
        assert (rims.normals[top & ~left & ~right][:, 1] < -0.7).all()
        assert min(left.sum(), right.sum(), top.sum(), bottom.sum()) > 25


def test_a_slope_and_an_empty_image_have_none() -> None:
    slope = np.linspace(1, 3, 160, dtype=np.float32)[None].repeat(120, axis=0)
    for depth in (slope, np.zeros((120, 160), np.float32)):
        assert len(find_depth_rims(Frame(0, 0.0, np.zeros((120, 160, 3), np.uint8), depth, CAMERA))) == 0
