"""The parts of the pose estimation: motions, registration, the colour camera, places and the pose graph."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from data_tools.synthetic.camera.sensor_model import SensorModel
from data_tools.synthetic.synthetic_scene import SyntheticScene
from razer.frame import Frame, Intrinsics
from razer.geometry import inverse, is_rigid
from slam.backend.loop_closure import plausible
from slam.backend.place_recognition import PlaceRecognition
from slam.backend.pose_graph import EDGE_BELIEF, PoseEdge, PoseGraph, mahalanobis
from slam.frontend.color_calibration import NOMINAL, ColorCamera, drift
from slam.frontend.correspondences import Correspondences, solve_pnp
from slam.frontend.depth_pyramid import depth_pyramid, fine_depth, halved
from slam.frontend.features import FeatureExtractor, Features, matches
from slam.frontend.icp import icp
from slam.frontend.keyframes import Keyframe, View
from slam.frontend.view_registration import is_trusted, register_views
from slam.se3 import adjoint, angle_deg, exp_se3, length_m


@pytest.fixture
def rng():
    return np.random.default_rng(7)


twists = st.lists(st.floats(-1, 1), min_size=6, max_size=6).map(np.array)


@given(twists, twists)
def test_the_adjoint_carries_small_motions_from_one_frame_to_the_other(pose, twist):
    transform, small = exp_se3(pose), 1e-6 * twist
    assert is_rigid(transform)
    carried = exp_se3(adjoint(transform) @ small) @ transform
    np.testing.assert_allclose(carried, transform @ exp_se3(small), atol=1e-11)


def test_angle_and_length_of_a_motion():
    turned = exp_se3(np.array([0.0, np.radians(30), 0.0, 0.0, 3.0, 4.0]))
    assert angle_deg(turned) == pytest.approx(30)
    assert length_m(turned) == pytest.approx(5)
    assert angle_deg(exp_se3(np.full(6, 1e-7))) == pytest.approx(np.degrees(np.sqrt(3) * 1e-7), rel=1e-6)


def test_halving_takes_the_nearer_surface_and_keeps_the_camera():
    camera = Intrinsics(4, 2, 4.0, 4.0, 1.5, 0.5)
    depth = np.array([[1.0, 1.0, 2.0, 0.0], [1.0, 3.0, 0.0, 0.0]], np.float32)
    half, smaller = halved(depth, camera)
    np.testing.assert_allclose(half, [[1.0, 2.0]])
    # The ray through the middle of four pixels is the ray through the one they became.
    assert (0.5 - camera.cx) / camera.fx == pytest.approx((0 - smaller.cx) / smaller.fx)


def test_points_and_normals_of_a_slanted_plane():
    camera = Intrinsics(160, 120, 130.0, 130.0, 79.5, 59.5)
    normal = np.array([0.3, -0.2, -1.0]) / np.linalg.norm([0.3, -0.2, -1.0])
    u, v = np.meshgrid(np.arange(160), np.arange(120))
    rays = np.stack([(u - camera.cx) / camera.fx, (v - camera.cy) / camera.fy, np.ones_like(u)])
    depth = (normal @ np.array([0, 0, 2.0]) / np.tensordot(normal, rays, 1)).astype(np.float32)
    grid = depth_pyramid(depth, camera)[-1]
    assert grid.valid.mean() > 0.95
    np.testing.assert_allclose(grid.sample_normals.T, np.tile(normal, (grid.sample_normals.shape[1], 1)), atol=2e-3)
    assert (normal @ grid.sample_points == pytest.approx(normal[2] * 2.0, abs=1e-4)) is True


@pytest.fixture(scope="module")
def room():
    return SyntheticScene("room", 3, 60, sensor=SensorModel.kinect())


@pytest.fixture(scope="module")
def views(room):
    finder = FeatureExtractor()
    return {i: View.of(room[i], finder, ColorCamera.nominal()) for i in (10, 12)}


def test_two_views_of_a_room_are_brought_together_from_any_guess_nearby(room, views):
    truth = inverse(room[10].pose) @ room[12].pose
    grids = {i: view.grids() for i, view in views.items()}
    for twist in ([0, 0, 0, 0, 0, 0], [0.02, -0.02, 0.01, 0.03, -0.03, 0.02], [-0.03, 0.01, 0.02, -0.04, 0.01, 0.03]):
        guess = exp_se3(np.array(twist)) @ truth
        found = register_views(views[10], grids[10], views[12], grids[12], [guess], ColorCamera.nominal())
        assert found is not None
        assert is_trusted(found)
        off = inverse(truth) @ found.target_from_source
        assert length_m(off) < 0.006
        assert angle_deg(off) < 0.15


def test_features_alone_find_the_motion_without_a_guess(room, views):
    truth = inverse(room[10].pose) @ room[12].pose
    pairs = matches(views[10].features, views[12].features)
    sightings = Correspondences.of(views[10].features, views[12].features, pairs, np.zeros(3), np.zeros(3))
    start = solve_pnp(sightings, ColorCamera.nominal(), 100)
    assert start is not None
    assert length_m(inverse(truth) @ start) < 0.1
    assert angle_deg(inverse(truth) @ start) < 2


def test_features_say_where_a_bare_wall_leaves_the_motion_open(rng):
    camera = Intrinsics(640, 480, 525.0, 525.0, 319.5, 239.5)
    wall = np.full((480, 640), 2.0, np.float32)
    grids = depth_pyramid(*fine_depth(wall, camera))
    truth = exp_se3(np.array([0, 0, 0, 0.03, -0.02, 0.0]))
    rays = rng.uniform(-0.5, 0.5, (80, 2))
    points = np.column_stack([rays, np.ones(80)]) * 2.0
    seen = (points - truth[:3, 3])[:, :2] / 2.0
    sightings = Correspondences.at_rest(rays, np.full(80, 2.0), seen, np.full(80, 1.5 / 525))
    alone = icp(grids, grids, np.eye(4), Correspondences.none(), ColorCamera.nominal())
    assert not is_trusted(alone)
    found = icp(grids, grids, np.eye(4), sightings, ColorCamera.nominal())
    assert length_m(inverse(truth) @ found.target_from_source) < 0.002
    assert is_trusted(found)


def planted(parameters, n, rng, turning=((0.0, 0.0, 0.0), (0.0, 0.0, 0.0))):
    """Sightings whose rays a colour camera of the given parameters saw while it turned so, and the true motion."""
    truth = exp_se3(rng.normal(0, [0.1, 0.1, 0.1, 0.05, 0.05, 0.05]))
    points = np.column_stack([rng.uniform(-1.2, 1.2, (n, 2)), rng.uniform(1.5, 3.5, n)])
    there = points @ inverse(truth)[:3, :3].T + inverse(truth)[:3, 3]
    turning = np.array(turning)
    rays, drifts = zip(
        *(
            observed(p + np.array([parameters[5], 0, 0]), parameters, w)
            for p, w in zip((points, there), turning, strict=True)
        ),
        strict=True,
    )
    return Correspondences(rays[0], points[:, 2], rays[1], np.full(n, 1.5 / 525), *drifts), truth


def observed(points, parameters, turning):
    """Nominal rays that have the bearings of the points, by iteration, and their drifts: each point is seen by the
    camera as it stands when the row is read on which it appears."""
    bearing = points[:, :2] / points[:, 2:]
    rays, drifts = bearing, np.zeros_like(bearing)
    for _ in range(40):
        lateness = rays[:, 1]  # of an image that spans a bearing of 1
        drifts = drift(rays, lateness, turning)
        squared = (rays**2).sum(axis=1, keepdims=True)
        radial = parameters[0] + parameters[1] * squared + parameters[2] * squared**2
        rays = (bearing - parameters[3:5] - parameters[6] * drifts) / radial
    return rays, drifts


def test_drifts_are_what_a_camera_that_turns_sees_a_moment_later(rng):
    rays, turning = rng.uniform(-0.6, 0.6, (30, 2)), np.array([0.4, -1.1, 0.3])
    # A ray read `moment` after the image's middle, told in the axes the camera has in the middle.
    moment = 1e-6
    turned = np.column_stack([rays, np.ones(30)]) @ exp_se3(np.r_[turning * moment, 0, 0, 0])[:3, :3].T
    expected = (turned[:, :2] / turned[:, 2:] - rays) / moment
    np.testing.assert_allclose(drift(rays, np.ones(30), turning), expected, atol=1e-5)
    np.testing.assert_allclose(drift(rays, np.full(30, -0.5), turning), -expected / 2, atol=1e-5)


def test_how_long_the_colour_camera_reads_is_learnt_while_it_turns(rng):
    true = np.array([1.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.02])
    camera = ColorCamera.nominal()
    for _ in range(40):
        sightings, truth = planted(true, 150, rng, rng.normal(0, 0.7, (2, 3)))
        camera = learnt_at(truth, sightings, camera, rng)
    assert camera.parameters[6] == pytest.approx(0.02, abs=0.001)
    assert camera.parameters[0] == pytest.approx(1.0, abs=0.01)


def test_residuals_vanish_at_the_truth_and_their_derivatives_are_right(rng):
    parameters = np.array([1.05, 0.02, 0.01, 0.01, -0.02, 0.02, 0.025])
    sightings, truth = planted(parameters, 40, rng, rng.normal(0, 0.8, (2, 3)))
    np.testing.assert_allclose(sightings.residuals(truth, parameters), 0, atol=1e-6)
    pose, off = exp_se3(rng.normal(0, 0.01, 6)) @ truth, parameters + rng.normal(0, 0.01, 7)
    term = sightings.term(pose, off)

    # The gradient of the Cauchy cost 2 log(1 + r^2 / 4), by central differences.
    def cost(x):
        squared = (sightings.residuals(exp_se3(x[:6]) @ pose, off + x[6:]) ** 2).sum(axis=1)
        return 2 * np.log1p(squared / 4).sum()

    steps = 1e-6 * np.eye(13)
    numeric = np.array([(cost(step) - cost(-step)) / 2e-6 for step in steps])
    np.testing.assert_allclose(-term.gradient, numeric, rtol=1e-4, atol=1e-4 * np.abs(numeric).max())


def learnt_at(truth, sightings, camera, rng):
    """The camera after sightings, made noisy, of a motion that is known."""
    noise = rng.normal(0, 0.7 / 525, sightings.source_rays.shape)
    noisy = replace(sightings, source_rays=sightings.source_rays + noise)
    bend = np.zeros_like(camera.parameters)
    for _ in range(3):
        term = noisy.term(truth, camera.parameters + bend)
        likelihood = term.information[6:, 6:]
        bend += np.linalg.solve(likelihood + camera.information, term.gradient[6:] - camera.information @ bend)
    return camera.learnt(bend, likelihood)


def test_the_colour_camera_is_learnt_from_motions_that_depth_tells(rng):
    true = np.array([1.1, -0.03, 0.0, 0.02, -0.01, 0.025, 0.0])
    camera = ColorCamera.nominal()
    for _ in range(60):
        sightings, truth = planted(true, 150, rng)
        camera = learnt_at(truth, sightings, camera, rng)
    assert camera.parameters[0] == pytest.approx(1.1, abs=0.01)
    rays = rng.uniform(-0.5, 0.5, (100, 2))
    off = camera.bearings(rays) - ColorCamera(true, camera.information).bearings(rays)
    assert np.abs(off).max() < 3 / 525  # it was up to 30 pixels


def test_a_registered_camera_stays_nominal(rng):
    camera = ColorCamera.nominal()
    sightings, truth = planted(NOMINAL, 200, rng)
    noisy = replace(sightings, source_rays=sightings.source_rays + rng.normal(0, 1.5 / 525, (200, 2)))
    term = noisy.term(truth, camera.parameters)
    likelihood = term.information[6:, 6:]
    bend = np.linalg.solve(likelihood + camera.information, term.gradient[6:])
    assert np.abs(camera.learnt(bend, likelihood).parameters - NOMINAL).max() < 0.03


def described(rng, n=200):
    descriptors = rng.integers(0, 256, (n, 32)).astype(np.uint8)
    return Features(np.zeros((n, 2)), descriptors, np.ones(n), np.ones(n), np.zeros(n))


def test_a_place_seen_again_is_the_most_alike(rng):
    places, scenes = PlaceRecognition(), [described(rng) for _ in range(70)]
    for scene in scenes:
        places.add(scene)
    flips = np.packbits(rng.random((200, 256)) < 0.05, axis=1)
    again = replace(scenes[17], descriptors=scenes[17].descriptors ^ flips)
    alike = places.similar(again)
    assert alike.shape == (70,)
    assert alike.argmax() == 17
    assert places.similar(described(rng)).max() < alike[17]


def circle(n):
    return [
        exp_se3(np.array([0, 2 * np.pi * i / n, 0, 0, 0, 0])) @ exp_se3(np.array([0, 0, 0, 0, 0, 2.0]))
        for i in range(n)
    ]


def edges_of(poses, pairs, rng, sigma, sure=True, noise=1.0):
    information = np.eye(6) / sigma**2 / EDGE_BELIEF
    off = [exp_se3(noise * rng.normal(0, sigma, 6)) for _ in pairs]
    return [
        PoseEdge(a, b, o @ inverse(poses[a]) @ poses[b], information, sure)
        for o, (a, b) in zip(off, pairs, strict=True)
    ]


def graph_of(poses, edges):
    graph = PoseGraph()
    for number in range(len(poses)):
        before = [e for e in edges if e.b == number and e.a == number - 1]
        start = graph.poses[number - 1] @ before[0].a_from_b if before else poses[number]
        graph.add_keyframe(number, start)
        for edge in edges:
            if max(edge.a, edge.b) == number:
                graph.add_edge(edge)
        graph.optimise()
    return graph


def worst_m(found, poses):
    return max(length_m(inverse(poses[n]) @ pose) for n, pose in found.items())


def test_exact_edges_have_the_truth_as_their_optimum(rng):
    poses = circle(12)
    poses = [inverse(poses[0]) @ pose for pose in poses]
    edges = edges_of(poses, [(i, i + 1) for i in range(11)] + [(0, 11), (2, 7)], rng, 0.01, noise=0)
    assert worst_m(graph_of(poses, edges).poses, poses) < 1e-6


def test_a_loop_takes_drift_away_and_a_false_one_does_not_bend_the_path(rng):
    poses = circle(40)
    poses = [inverse(poses[0]) @ pose for pose in poses]
    steps = edges_of(poses, [(i, i + 1) for i in range(39)], rng, 0.01)
    drifted = worst_m(graph_of(poses, steps).poses, poses)
    loops = edges_of(poses, [(0, 39), (1, 38), (0, 38)], rng, 0.01, sure=False)
    closed = graph_of(poses, steps + loops)
    tied = dict(closed.smooth())
    assert worst_m(tied, poses) < 0.7 * drifted
    wrong = PoseEdge(5, 25, exp_se3(np.array([0, 1.0, 0, 1.0, 0, 0])), loops[0].information)
    misled = graph_of(poses, [*steps, *loops, wrong])
    assert max(length_m(inverse(tied[n]) @ pose) for n, pose in misled.smooth().items()) < 0.01
    assert mahalanobis(wrong, misled.poses) > 10 * max(mahalanobis(e, misled.poses) for e in loops)


def test_covariance_grows_along_a_path_without_loops(rng):
    poses = circle(20)
    graph = graph_of(poses, edges_of(poses, [(i, i + 1) for i in range(19)], rng, 0.01))
    spread = [np.trace(graph.covariance(n)) for n in (1, 10, 19)]
    assert spread[0] < spread[1] < spread[2]


def test_covariance_is_along_the_keyframes_own_axes():
    turned = exp_se3(np.array([0, np.pi / 2, 0, 0, 0, 0]))  # the second keyframe's x axis is minus the first one's z
    information = np.diag([1e4, 1e4, 1e4, 1e4, 1e4, 1e2]) / EDGE_BELIEF  # the shift along the first one's z is vague
    graph = graph_of([np.eye(4), turned], [PoseEdge(0, 1, turned, information, sure=True)])
    expected = np.diag([1e-4, 1e-4, 1e-4, 1e-2, 1e-4, 1e-4])
    np.testing.assert_allclose(graph.covariance(1), expected, atol=1e-6)
    np.testing.assert_allclose(graph.covariances()[1], expected, atol=1e-6)
    in_world = turned[:3, :3] @ graph.covariance(1)[3:, 3:] @ turned[:3, :3].T
    np.testing.assert_allclose(in_world, np.diag([1e-4, 1e-4, 1e-2]), atol=1e-6)


def test_covariances_are_of_the_present_poses_and_edges(rng):
    poses = circle(20)
    poses = [inverse(poses[0]) @ pose for pose in poses]
    steps = edges_of(poses, [(i, i + 1) for i in range(19)], rng, 0.01)
    graph = graph_of(poses, steps)
    before = dict(graph.poses)
    open_end = graph.covariances()
    for number, covariance in open_end.items():
        np.testing.assert_allclose(covariance, graph.covariance(number), rtol=0.05, atol=1e-9)
        assert (covariance == covariance.T).all()
    assert all((graph.poses[number] == pose).all() for number, pose in before.items())
    graph.replace([*steps, *edges_of(poses, [(0, 19)], rng, 0.01)])
    assert graph.covariance(10) is None  # iSAM2 was begun anew and has solved nothing yet
    closed = graph.covariances()
    assert list(closed) == list(range(20))
    assert all(np.trace(closed[n]) < np.trace(open_end[n]) for n in range(5, 20))


def test_a_lookalike_farther_off_than_drift_explains_is_another_place(views):
    def keyframe(number, x_m, travelled_m):
        return Keyframe(number, 0, views[10], exp_se3(np.array([0, 0, 0, x_m, 0, 0])), travelled_m)

    near, far = keyframe(30, 0.3, 12.0), keyframe(31, 3.0, 12.0)
    assert plausible(keyframe(0, 0.0, 0.0), near, np.eye(4))
    assert not plausible(keyframe(0, 0.0, 0.0), far, np.eye(4))


def test_an_image_without_corners_has_no_features():
    camera = Intrinsics(64, 48, 50.0, 50.0, 31.5, 23.5)
    black = Frame(0, 0.0, np.zeros((48, 64, 3), np.uint8), np.ones((48, 64), np.float32), camera)
    features = FeatureExtractor().find(black, ColorCamera.nominal())
    assert len(features) == 0
    assert len(matches(features, features)) == 0
