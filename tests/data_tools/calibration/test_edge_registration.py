"""Registration of rims to edges on drawn boxes: the planted camera is found, whatever single frames do."""

from __future__ import annotations

import cv2
import numpy as np
import pytest

from data_tools.calibration.color_camera import REGISTERED, ColorProjection
from data_tools.calibration.color_edges import ColorEdges
from data_tools.calibration.depth_rims import DepthRims
from data_tools.calibration.edge_registration import COARSE_PX, FINE_PX, EdgeFit, EdgeRegistration, RimView
from razer.arrays import Float64Array
from razer.frame import Intrinsics

CAMERA = Intrinsics(320, 240, 260.0, 260.0, 159.5, 119.5)
MODEL = ColorProjection(CAMERA)
DEPTHS_M = np.array([1.0, 2.0, 4.0])
PLANTED = [
    [1.06, 0, 0, 0, 0, 0, 0],
    [1, 7, -5, 0, 0, 0, 0],
    [1, 0, 0, 0.04, -0.03, 0.02, 0],
    [1, 0, 0, 0, 0, 0, 0.02],
    [0.93, -6, 4, -0.03, 0.02, -0.02, -0.015],
]


def boxes(index: int) -> tuple[Float64Array, Float64Array]:
    """Corners (N, 4, 2) of upright rectangles in the depth image, and their depths (N,), all inside of it."""
    rng = np.random.default_rng(index)
    centers, half = rng.uniform((60, 50), (260, 190), (7, 2)), rng.uniform(8, 28, (7, 1, 2))
    corners = centers[:, None] + half * np.array([(-1, -1), (1, -1), (1, 1), (-1, 1)])
    return corners, np.sort(rng.uniform(0.9, 4, 7))[::-1]


def view(parameters: Float64Array, index: int, offset_px: tuple[float, float], flow_px: tuple[float, float]) -> RimView:
    """A frame of boxes: rims along the border of each that nothing nearer covers, and colour as another camera sees it,
    moved by an offset."""
    corners, depths = boxes(index)
    image = np.full((240, 320, 3), 90, np.uint8)
    rays, near, normals = [], [], []
    for number, (rectangle, depth) in enumerate(zip(corners, depths, strict=True)):
        ray = (rectangle - (CAMERA.cx, CAMERA.cy)) / (CAMERA.fx, CAMERA.fy)
        drawn = MODEL.pixels(parameters, ray, np.full(4, 1 / depth)) + offset_px
        shade = (40, 200, 130, 240, 10, 170, 70)[number]
        cv2.fillPoly(image, [np.round(drawn * 16).astype(np.int32)], (shade,) * 3, lineType=cv2.LINE_AA, shift=4)
        outward = np.array([(0, -1), (1, 0), (0, 1), (-1, 0)], np.float64)
        for a, b, normal in zip(rectangle, np.roll(rectangle, -1, axis=0), outward, strict=True):
            along = a + np.linspace(0.1, 0.9, 20)[:, None] * (b - a)
            covered = [
                (np.abs(along - other.mean(axis=0)) < np.abs(other[0] - other.mean(axis=0)) + 2).all(axis=1)
                for other in corners[number + 1 :]
            ]
            seen = ~np.any(covered, axis=0) if covered else np.ones(20, bool)
            rays.append((along[seen] - (CAMERA.cx, CAMERA.cy)) / (CAMERA.fx, CAMERA.fy))
            near.append(np.full(seen.sum(), 1 / depth))
            normals.append(np.tile(normal, (seen.sum(), 1)))
    rims = DepthRims(np.concatenate(rays), np.concatenate(near), np.concatenate(normals))
    return RimView(rims, ColorEdges.of(image), np.array(flow_px))


def fitted(views: list[RimView]) -> EdgeFit:
    registration = EdgeRegistration(views, MODEL)
    return registration.fit(EdgeFit.start(REGISTERED, len(registration)), (*COARSE_PX, *FINE_PX))


@pytest.mark.parametrize("planted", PLANTED)
def test_the_planted_camera_is_found(planted: list[float]) -> None:
    true = np.array(planted)
    fit = fitted([view(true, index, (0, 0), (0, 0)) for index in range(24)])
    assert MODEL.displacement_px(fit.parameters, true, DEPTHS_M).max() < 2.0
    assert fit.residual_px < 1.5


def test_frames_that_are_off_on_their_own_do_not_move_the_camera() -> None:
    true = np.array(PLANTED[1], np.float64)
    offsets = [(9.0, 0.0) if index < 3 else (0.0, 0.0) for index in range(12)]
    fit = fitted([view(true, index, offset, (0, 0)) for index, offset in enumerate(offsets)])
    assert MODEL.displacement_px(fit.parameters, true, DEPTHS_M).max() < 1.5
    np.testing.assert_allclose(fit.offsets_px[:3, 0], 9, atol=1.5)
    assert np.abs(fit.offsets_px[3:]).max() < 1.5


def test_a_lag_between_colour_and_depth_is_told_from_a_shift() -> None:
    true, lag = np.array(PLANTED[1], np.float64), 0.4
    flows = [(14.0, 0.0), (18.0, 2.0), (20.0, -3.0), (22.0, 0.0), (16.0, 1.0), (15.0, 0.0), (1.0, 0.0), (0.0, 0.0)]
    flows += [(17.0, -1.0), (19.0, 2.0)]
    views = [view(true, i, (lag * flow[0], lag * flow[1]), flow) for i, flow in enumerate(flows)]
    fit = fitted(views)
    assert fit.lag == pytest.approx(lag, abs=0.08)
    assert MODEL.displacement_px(fit.parameters, true, DEPTHS_M).max() < 2.0


def test_rims_score_on_their_own_edges_and_not_on_those_of_others() -> None:
    views = [view(REGISTERED, index, (0, 0), (0, 0)) for index in range(6)]
    others = [RimView(a.rims, b.edges, a.flow_px) for a, b in zip(views, views[3:] + views[:3], strict=True)]
    fit = EdgeFit.start(REGISTERED, 6)
    own, chance = (EdgeRegistration(of, MODEL).score(fit, 1.4) for of in (views, others))
    assert own > 5 * chance
