"""The pose graph: optimum, loops, false edges, covariances."""

from __future__ import annotations

from dataclasses import FrozenInstanceError, replace

import gtsam
import numpy as np
import pytest

from razer.geometry import inverse
from slam.backend.pose_graph import GEMAN_MCCLURE, PRIOR_HUBER, PoseGraph, _prior_factor, mahalanobis
from slam.pose_edge import EDGE_SHARE, PoseEdge, PosePrior
from slam.se3 import adjoint, exp_se3, length_m


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


def moved(x_m):
    result = np.eye(4)
    result[0, 3] = x_m
    return result


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


def line_edge(a, b, length, sigma, is_odometry):
    """An edge along x, whose residual in sigmas is that of its length alone."""
    return PoseEdge(a, b, shifted(length), np.eye(6) / sigma**2 / EDGE_SHARE, is_odometry)


def shifted(x_m):
    return exp_se3(np.array([0, 0, 0, x_m, 0, 0]))


def test_residuals_of_a_registration_count_by_three_in_a_thousand():
    edge = PoseEdge(0, 1, np.eye(4), np.diag([1.0, 1, 1, 1e6, 1, 1]))
    assert mahalanobis(edge, {0: np.eye(4), 1: shifted(0.1)}) == pytest.approx(0.1 * np.sqrt(0.003 * 1e6))


def huber(sigmas, k=0.5):
    return np.where(np.abs(sigmas) < k, sigmas**2 / 2, k * (np.abs(sigmas) - k / 2))


def geman_mcclure(sigmas, c=3.0):
    return sigmas**2 * c**2 / (sigmas**2 + c**2) / 2


@pytest.mark.parametrize("gap_sigmas", [0.3, 1.5, 6.0])
def test_edges_that_disagree_meet_where_their_robust_costs_are_least(gap_sigmas):
    sigma = 0.1
    tracked, closed = 1.0, 1.0 + gap_sigmas * sigma
    edges = [line_edge(0, 1, tracked, sigma, True), line_edge(0, 1, closed, sigma, False)]
    graph = graph_of([np.eye(4), shifted(tracked)], edges)
    # Uphill from the tracked pose to the closed one: the first dip is where the descent ends, however deep the others.
    x = np.linspace(tracked, closed, 100_001)
    costs = huber((x - tracked) / sigma) + geman_mcclure((x - closed) / sigma)
    dip = np.argmax(np.diff(costs) > 0)
    assert dip > 0
    assert graph.smooth()[1][0, 3] == pytest.approx(x[dip], abs=1e-3)


def test_an_edge_is_never_all_but_unknown_nor_all_but_exact():
    # Per axis: known much too well, not at all, and something between that is no whole number.
    information = np.diag([1e12, 1e-9, 2.5, 0.4e-9, 1e12, 7.3]) / EDGE_SHARE
    graph = graph_of([np.eye(4), np.eye(4)], [PoseEdge(0, 1, np.eye(4), information, is_odometry=True)])
    anchored = 1e-8
    expected = np.array([1e-7, 1, 1 / 2.5, 1, 1e-7, 1 / 7.3]) + anchored
    np.testing.assert_allclose(np.diag(graph.covariance(1)), expected, rtol=1e-3)


def test_information_about_oblique_axes_is_bounded_along_them_and_turns_with_the_edge():
    axes = np.linalg.qr(np.random.default_rng(0).normal(size=(6, 6)))[0]
    bounded = axes @ np.diag([1e2, 1e3, 1e4, 1e2, 1e3, 1.0]) @ axes.T
    moved = exp_se3(np.array([0.3, -0.5, 0.2, 1.0, 2.0, -0.5]))
    # The information is that of a left perturbation; what the graph takes is that of the keyframe's own axes.
    back = np.linalg.inv(adjoint(moved))
    given = back.T @ (axes @ np.diag([1e2, 1e3, 1e4, 1e2, 1e3, 1e-3]) @ axes.T) @ back / EDGE_SHARE
    graph = graph_of([np.eye(4), moved], [PoseEdge(0, 1, moved, given, is_odometry=True)])
    np.testing.assert_allclose(graph.covariance(1), np.linalg.inv(bounded), rtol=1e-3, atol=1e-6)
    off = exp_se3(np.array([0, 0, 0, 0, 0, 1e-4]))
    edge = PoseEdge(0, 1, moved, given)
    twist = np.array([0, 0, 0, 0, 0, 1e-4])
    assert mahalanobis(edge, {0: np.eye(4), 1: moved @ off}) == pytest.approx(np.sqrt(twist @ bounded @ twist))
    assert mahalanobis(edge, {0: np.eye(4), 1: moved}) == pytest.approx(0, abs=1e-6)


def two_submaps():
    """Keyframes 0-2 and, joined with them by no edge, 3-5."""
    graph, rng = PoseGraph(), np.random.default_rng(0)
    poses = [shifted(0.5 * n) for n in range(6)]
    for number, pose in enumerate(poses):
        graph.add_keyframe(number, pose, unanchored=number == 3)
    for edge in edges_of(poses, [(0, 1), (1, 2), (3, 4), (4, 5)], rng, 0.01, noise=0):
        graph.add_edge(edge)
    graph.optimise()
    return graph, poses


def test_what_begins_a_submap_hangs_loose_and_what_is_the_world_does_not():
    graph, _ = two_submaps()

    def sigmas(covariances):
        return [np.sqrt(covariances[n][0, 0]) for n in (0, 3)]

    assert sigmas(graph.covariances()) == pytest.approx([1e-4, 10], rel=1e-2)
    assert sigmas({n: graph.covariance(n) for n in (0, 3)}) == pytest.approx([1e-4, 10], rel=1e-2)
    graph.replace(graph.edges)
    graph.optimise()
    assert sigmas({n: graph.covariance(n) for n in (0, 3)}) == pytest.approx([1e-4, 10], rel=1e-2)
    graph.fix(3)
    assert sigmas(graph.covariances()) == pytest.approx([10, 1e-4], rel=1e-2)
    graph.optimise()
    assert sigmas({n: graph.covariance(n) for n in (0, 3)}) == pytest.approx([10, 1e-4], rel=1e-2)


def test_a_submap_that_was_moved_stays_where_it_was_put():
    graph, poses = two_submaps()
    onto = exp_se3(np.array([0.4, 0.2, -1.0, 3.0, 1.0, 0.0]))
    moved = {n: onto @ pose if n >= 3 else pose for n, pose in enumerate(poses)}
    graph.shift(moved)
    assert worst_m(graph.poses, moved) < 1e-12
    assert worst_m(graph.optimise(), moved) < 1e-6
    assert worst_m(graph.smooth(), moved) < 1e-6
    assert len(graph.edges) == 4


def test_keyframes_that_nothing_holds_are_solved_for_all_the_same():
    """iSAM2 raises where the system is singular; the damped solution is taken, and later edges count as ever."""
    graph, poses = two_submaps()
    for number, x_m in ((6, 9.0), (7, 9.4)):
        graph.add_keyframe(number, shifted(x_m))
    graph.add_edge(line_edge(6, 7, 0.5, 0.01, True))
    solved = graph.optimise()
    assert worst_m({n: solved[n] for n in range(6)}, poses) < 1e-6
    assert length_m(inverse(solved[6]) @ solved[7]) == pytest.approx(0.5)
    assert graph.covariances() == {}
    graph.add_edge(line_edge(5, 6, 0.5, 0.01, True))
    assert worst_m(graph.optimise(), [*poses, shifted(3.0), shifted(3.5)]) < 1e-6
    assert sorted(graph.covariances()) == list(range(8))


def test_first_guesses_far_off_are_led_to_the_optimum_step_by_step():
    rng = np.random.default_rng(0)
    poses = circle(8)
    poses = [inverse(poses[0]) @ pose for pose in poses]
    graph = PoseGraph()
    for number, pose in enumerate(poses):
        graph.add_keyframe(number, pose @ exp_se3(rng.normal(0, 0.1, 6)) if number else pose)
    for edge in edges_of(poses, [(i, (i + 1) % 8) for i in range(7)] + [(0, 4)], rng, 0.01, noise=0):
        graph.add_edge(edge)
    for _ in range(4):
        graph.optimise()
    assert worst_m(graph.poses, poses) < 1e-3


class Marginals:
    """iSAM2 as far as it tells marginals: those it is given, or an error."""

    def __init__(self, marginal):
        self.marginal = marginal

    def marginalCovariance(self, number):  # noqa: N802 - GTSAM's name
        if isinstance(self.marginal, Exception):
            raise self.marginal
        return self.marginal


INDEFINITE = np.diag([-1e-9, 1.0, 1.0, 1.0, 1.0, 1.0])


@pytest.mark.parametrize(
    "marginal",
    [INDEFINITE, np.diag([0.0, 1, 1, 1, 1, 1]), np.full((6, 6), np.nan), RuntimeError("singular"), IndexError("new")],
    ids=["indefinite", "singular", "not finite", "unsolvable", "unknown"],
)
def test_a_marginal_that_is_no_covariance_is_none(marginal):
    graph, _ = two_submaps()
    graph._isam = Marginals(marginal)
    assert graph.covariance(1) is None


def test_a_marginal_is_symmetric_whatever_rounding_did():
    graph, _ = two_submaps()
    rounded = np.eye(6)
    rounded[0, 5] = 0.25
    graph._isam = Marginals(rounded)
    expected = np.eye(6)
    expected[0, 5] = expected[5, 0] = 0.125
    np.testing.assert_array_equal(graph.covariance(1), expected)


def test_an_edge_is_a_value():
    edge = line_edge(0, 1, 1.0, 0.1, False)
    assert not PoseEdge(0, 1, edge.a_from_b, edge.information).is_odometry
    with pytest.raises(FrozenInstanceError):
        edge.a = 3


def test_poses_that_an_optimisation_did_not_change_are_the_same_arrays(rng):
    poses = [inverse(circle(30)[0]) @ pose for pose in circle(30)]
    graph = graph_of(poses, edges_of(poses, [(i, i + 1) for i in range(29)], rng, 0.01))
    before = dict(graph.poses)
    graph.add_keyframe(30, graph.poses[29])
    graph.add_edge(PoseEdge(29, 30, np.eye(4), np.eye(6) * 1e6, is_odometry=True))
    after = graph.optimise()
    assert sum(after[n] is not pose for n, pose in before.items()) == 0
    graph.add_edge(PoseEdge(0, 29, inverse(poses[0]) @ poses[29], np.eye(6) * 1e8))
    assert sum(graph.optimise()[n] is not pose for n, pose in before.items()) > 20


def test_the_table_of_edges_grows_with_them_and_begins_anew_with_others(rng):
    poses = circle(8)
    edges = edges_of(poses, [(i, i + 1) for i in range(7)], rng, 0.01)
    graph = graph_of(poses, edges)
    assert graph.edge_table()[0].tolist() == [[i, i + 1] for i in range(7)]
    graph.add_edge(replace(edges[0], b=5, is_odometry=False))
    ends, is_odometry = graph.edge_table()
    assert ends[-1].tolist() == [0, 5]
    assert is_odometry.tolist() == [True] * 7 + [False]
    graph.replace(edges[2:4])
    assert graph.edge_table()[0].tolist() == [[2, 3], [3, 4]]


def test_edges_count_in_the_network_by_what_they_still_pull():
    graph, information = PoseGraph(), np.eye(6) * 1e4 / EDGE_SHARE
    graph.add_keyframe(0, np.eye(4))
    graph.add_keyframe(1, moved(0.0))
    edges = [PoseEdge(0, 1, moved(0.0), information, is_odometry=True), PoseEdge(0, 1, moved(0.05), information)]
    for edge in edges:
        graph.add_edge(edge)
    graph.doubt_edges()
    sigmas = 0.05 / 0.01
    doubted = edges[1].variance_m2 * (1 + (sigmas / GEMAN_MCCLURE) ** 2) ** 2
    assert graph.network.variances_from(0)[1] == pytest.approx(1 / (1 / edges[0].variance_m2 + 1 / doubted), rel=1e-6)


def test_a_prior_pulls_no_more_strongly_beyond_two_of_its_own_sigmas():
    """Ten sigmas away its cost is Huber's, in units of edges: k (r - k / 2)."""
    unit = 0.25
    factor = _prior_factor(PosePrior(None, 0, np.eye(4), np.full(6, 0.01), unit))
    values = gtsam.Values()
    values.insert(0, gtsam.Pose3(moved(0.1)))
    assert factor.error(values) == pytest.approx(PRIOR_HUBER * unit * (10 * unit - PRIOR_HUBER * unit / 2))


def test_longer_edges_displace_each_keyframe_by_its_share_of_the_way(rng):
    """A straight path whose steps are all a hundredth longer: the keyframe at 3 m moves by 3 cm, along its own axes."""
    poses = [moved(0.5 * n) for n in range(8)]
    edges = edges_of(poses, [(n, n + 1) for n in range(7)], rng, 0.01, noise=0.0)
    graph = graph_of(poses, edges)
    longer = [replace(edge, a_from_b=moved(0.505)) for edge in edges]
    displaced = graph.displacements(edges, longer)
    for number in range(8):
        np.testing.assert_allclose(displaced[number], [0, 0, 0, 0.005 * number, 0, 0], atol=1e-6)
    assert not any(np.abs(move).max() > 1e-9 for move in graph.displacements(edges, edges).values())
