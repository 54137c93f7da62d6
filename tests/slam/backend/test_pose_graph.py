"""The pose graph: optimum, loops, false edges, covariances."""

from __future__ import annotations

import numpy as np

from razer.geometry import inverse
from slam.backend.pose_graph import EDGE_SHARE, PoseEdge, PoseGraph, mahalanobis
from slam.se3 import exp_se3, length_m


def circle(n):
    return [
        exp_se3(np.array([0, 2 * np.pi * i / n, 0, 0, 0, 0])) @ exp_se3(np.array([0, 0, 0, 0, 0, 2.0]))
        for i in range(n)
    ]


def edges_of(poses, pairs, rng, sigma, is_odometry=True, noise=1.0):
    information = np.eye(6) / sigma**2 / EDGE_SHARE
    off = [exp_se3(noise * rng.normal(0, sigma, 6)) for _ in pairs]
    return [
        PoseEdge(a, b, o @ inverse(poses[a]) @ poses[b], information, is_odometry)
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


def worst_m(estimated, poses):
    return max(length_m(inverse(poses[n]) @ pose) for n, pose in estimated.items())


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
    loops = edges_of(poses, [(0, 39), (1, 38), (0, 38)], rng, 0.01, is_odometry=False)
    closed = graph_of(poses, steps + loops)
    connected = dict(closed.smooth())
    assert worst_m(connected, poses) < 0.7 * drifted
    wrong = PoseEdge(5, 25, exp_se3(np.array([0, 1.0, 0, 1.0, 0, 0])), loops[0].information)
    misled = graph_of(poses, [*steps, *loops, wrong])
    assert max(length_m(inverse(connected[n]) @ pose) for n, pose in misled.smooth().items()) < 0.01
    assert mahalanobis(wrong, misled.poses) > 10 * max(mahalanobis(e, misled.poses) for e in loops)


def test_covariance_grows_along_a_path_without_loops(rng):
    poses = circle(20)
    graph = graph_of(poses, edges_of(poses, [(i, i + 1) for i in range(19)], rng, 0.01))
    spread = [np.trace(graph.covariance(n)) for n in (1, 10, 19)]
    assert spread[0] < spread[1] < spread[2]


def test_covariance_is_along_the_keyframes_own_axes():
    turned = exp_se3(np.array([0, np.pi / 2, 0, 0, 0, 0]))  # the second keyframe's x axis is minus the first one's z
    information = np.diag([1e4, 1e4, 1e4, 1e4, 1e4, 1e2]) / EDGE_SHARE  # the shift along the first one's z is vague
    graph = graph_of([np.eye(4), turned], [PoseEdge(0, 1, turned, information, is_odometry=True)])
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
