"""A bare corridor without an end, made by hand: nothing says how far along it the camera moved, and poses say so."""

from __future__ import annotations

import numpy as np
import pytest

from app.benchmark.poses.consistency import pose_nees
from razer.frame import Frame, Intrinsics
from slam.frontend.color_calibration import ColorCalibration
from slam.frontend.icp import IcpResult
from slam.pose_edge import EDGE_SHARE
from slam.report import OpenStretch
from slam.se3 import exp_se3
from slam.system import SlamSystem
from slam.uncertainty.open_directions import OpenDirections

CAMERA = Intrinsics(320, 240, 260.0, 260.0, 159.5, 119.5)
WIDE_M, FLOOR_M, CEILING_M = 1.9, 1.2, -1.4
STEP_M, N_FRAMES = 0.05, 24


def corridor_depth(pose, rng, end_m):
    """Depth (H, W) of a corridor along z with an end wall at end_m, under the noise of a Kinect; nothing beyond 5 m."""
    v, u = np.mgrid[: CAMERA.height, : CAMERA.width]
    rays = np.stack([(u - CAMERA.cx) / CAMERA.fx, (v - CAMERA.cy) / CAMERA.fy, np.ones(u.shape)], axis=-1)
    rays, eye = rays @ pose[:3, :3].T, pose[:3, 3]
    depth = np.full(u.shape, np.inf)
    for axis, plane in ((0, -WIDE_M / 2), (0, WIDE_M / 2), (1, FLOOR_M), (1, CEILING_M), (2, end_m)):
        with np.errstate(divide="ignore"):
            z = (plane - eye[axis]) / rays[..., axis]
        depth = np.where(z > 0, np.minimum(depth, z), depth)
    depth += rng.normal(0, 0.0012 + 0.0019 * (depth.clip(0, 9) - 0.4) ** 2)
    return np.where(depth < 5, depth, 0).astype(np.float32)


def walked(end_m, rng, step_m=STEP_M):
    """What is reported of a finished walk down the corridor, and true poses. Colour is noise: nothing matches in it."""
    slam, truth = SlamSystem(), {}
    for index in range(N_FRAMES):
        truth[index] = exp_se3(np.array([0, 0.15 * np.sin(index / 5), 0, 0, 0, step_m * index]))
        grey = 128 + rng.integers(0, 60, (CAMERA.height, CAMERA.width, 1))
        rgb = np.broadcast_to(grey, (*grey.shape[:2], 3)).astype(np.uint8)
        slam.locate(Frame(index, index / 15, rgb, corridor_depth(truth[index], rng, end_m), CAMERA))
    slam.finish()
    return slam.report().graph, truth


def along_m(graph, truth):
    """Errors of the keyframes along the corridor, and the standard deviations that their covariances have there."""
    rotations = graph.world_from_camera[:, :3, :3]
    covariances = np.array([graph.covariances[frame][3:, 3:] for frame in graph.frames.tolist()])
    errors_m = [
        pose[2, 3] - truth[f][2, 3] for f, pose in zip(graph.frames.tolist(), graph.world_from_camera, strict=True)
    ]
    return np.array(errors_m), np.sqrt((rotations @ covariances @ rotations.swapaxes(1, 2))[:, 2, 2])


def test_along_a_corridor_without_an_end_the_error_is_inside_the_ellipsoid(rng):
    graph, truth = walked(np.inf, rng)
    errors_m, sigmas_m = along_m(graph, truth)
    assert np.abs(errors_m[1:]).max() > 0.2  # registration slides, and nothing tells it
    assert sigmas_m[1:].min() > 0.3
    assert (np.abs(errors_m[1:]) < 2 * sigmas_m[1:]).all()
    poses = dict(zip(graph.frames.tolist(), graph.world_from_camera, strict=True))
    assert pose_nees(poses, graph.covariances, truth).max() < 12.6  # 95 % of chi-square with 6 degrees of freedom
    (stretch,) = graph.open
    assert stretch.last == N_FRAMES - 1
    assert abs(stretch.axis[2]) > 0.95
    assert stretch.describe().endswith("how far the camera moved along its view, and poses there may be off")


def test_where_the_end_goes_out_of_sight_the_camera_goes_on_and_the_error_is_inside_the_ellipsoid(rng):
    """Backwards, away from an end wall, which is out of reach from halfway on."""
    graph, truth = walked(3.4, rng, -STEP_M)
    errors_m, sigmas_m = along_m(graph, truth)
    gone = np.array([truth[frame][2, 3] < -0.6 for frame in graph.frames.tolist()])
    assert 0 < gone.sum() < len(gone) - 1
    assert np.abs(errors_m).max() < 0.1 * STEP_M * N_FRAMES
    assert sigmas_m[gone].min() > 0.1
    assert (np.abs(errors_m[1:]) < 2 * sigmas_m[1:]).all()
    poses = dict(zip(graph.frames.tolist(), graph.world_from_camera, strict=True))
    assert pose_nees(poses, graph.covariances, truth).max() < 12.6  # 95 % of chi-square with 6 degrees of freedom
    (stretch,) = graph.open
    assert stretch.last == N_FRAMES - 1
    assert abs(stretch.axis[2]) > 0.95


def test_an_end_wall_closes_the_direction(rng):
    graph, truth = walked(3.8, rng)
    errors_m, sigmas_m = along_m(graph, truth)
    assert all(abs(stretch.axis[2]) < 0.1 for stretch in graph.open)  # the floor is out of view at the end
    assert np.abs(errors_m).max() < 0.005
    assert sigmas_m[1:].max() < 0.01


@pytest.mark.parametrize(("axis", "way"), [((0.9, 0.1, -0.4), "sideways"), ((0.1, -1.0, 0.0), "up or down")])
def test_a_stretch_is_told_in_a_line(axis, way):
    assert (
        f"frames 3 to 9: nothing in view says how far the camera moved {way},"
        in OpenStretch(3, 9, np.array(axis)).describe()
    )


def test_the_axis_is_along_the_camera_though_it_has_turned_from_its_keyframe():
    """What is open is the keyframe's view, from which the camera has turned by 60 degrees."""
    directions = OpenDirections()
    turned = exp_se3(np.array([0, np.radians(60), 0, 0, 0, 0]))
    information = np.diag([1e6, 1e6, 1e6, 1e6, 1e6, 1e-3]) / EDGE_SHARE
    color = ColorCalibration.nominal()
    for index in range(3):
        directions.see(index, IcpResult(turned, information, information, 0.9, 0.9, 0.9, 0.5, 0, color))
    (stretch,) = directions.stretches(1.0)
    np.testing.assert_allclose(np.abs(stretch.axis), np.abs(turned[2, :3]), atol=1e-3)
    assert "sideways" in stretch.describe()
