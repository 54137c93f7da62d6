"""Covariances as large as errors: the unit weight of graphs whose noise is known, open directions, and how firmly
keyframes are held."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.stats import chi2

from razer.geometry import inverse
from slam.backend.pose_graph import PoseGraph
from slam.frontend.icp import LEAST_INFORMATION
from slam.pose_edge import EDGE_SHARE, PoseEdge, unit_weight
from slam.se3 import exp_se3
from slam.uncertainty.correlated_errors import error_growth
from slam.uncertainty.pose_uncertainty import (
    ERRORS_IN_COMMON,
    USUAL,
    CovarianceScale,
    calibrated,
    covariances,
    local_sigmas_m,
)
from tests.support.pose_files import curved_path

N = 40
SIGMA = 0.02  # that edges count with, metres and radians
LOOPS = [(b - k, b) for b in range(N) for k in (2, 3, 7) if b >= k]


def noisy_graph(unit, rng, pairs=LOOPS, open_axes=()):
    """A path whose registrations err by `unit` of the sigmas they count with, smoothed; and the true poses."""
    truth = curved_path(N, 0.1)
    graph = PoseGraph()
    for number in range(N):
        graph.add_keyframe(number, truth[number])
    for a, b in [(n, n + 1) for n in range(N - 1)] + pairs:
        off = exp_se3(rng.normal(0, unit * SIGMA, 6))
        motion = off @ inverse(truth[a]) @ truth[b]
        information = np.eye(6) / SIGMA**2 / EDGE_SHARE
        information[open_axes, open_axes] = LEAST_INFORMATION
        graph.add_edge(PoseEdge(a, b, motion, information, b == a + 1))
    graph.optimise()
    graph.smooth()
    return graph, truth


@pytest.mark.parametrize("unit", [0.02, 0.1, 0.5])
def test_the_scale_is_that_of_the_noise(unit, rng):
    graph, _ = noisy_graph(unit, rng)
    assert CovarianceScale().measure(graph) == pytest.approx(ERRORS_IN_COMMON * unit, rel=0.25)


def test_of_edges_that_close_no_loop_nothing_is_measured(rng):
    graph, _ = noisy_graph(0.01, rng, [])
    assert unit_weight([], N - 1, N) is None
    assert CovarianceScale().measure(graph) == pytest.approx(ERRORS_IN_COMMON * USUAL)


def test_few_loops_say_little_and_more_say_more(rng):
    units = [CovarianceScale().measure(noisy_graph(0.01, rng, LOOPS[:n])[0]) for n in (0, 4, 20, 100)]
    assert units[0] > units[1] > units[2] > units[3]
    assert min(units) > 0.9 * 0.01 * ERRORS_IN_COMMON


def test_it_is_measured_anew_as_edges_become_more(rng):
    scale = CovarianceScale()
    few, _ = noisy_graph(0.02, rng, LOOPS[:80])
    before = scale.of(few)
    assert scale.of(noisy_graph(0.2, rng, LOOPS[:82])[0]) == before
    assert scale.of(noisy_graph(0.2, rng, LOOPS)[0]) > 4 * before


def test_errors_are_as_large_as_the_covariances_say():
    """Here registrations err each by itself, so that all that errors have in common is too much."""
    n_graphs, nees = 20, []
    for seed in range(n_graphs):
        graph, truth = noisy_graph((0.03, 0.3)[seed % 2], np.random.default_rng(seed))
        unit = CovarianceScale().measure(graph)
        covariance = covariances(graph, calibrated(graph, unit), unit)[N // 2]
        covariance /= ERRORS_IN_COMMON**2 * error_growth(graph)[N // 2]
        off = inverse(graph.poses[N // 2]) @ graph.poses[0] @ inverse(truth[0]) @ truth[N // 2]
        error = np.concatenate([[off[2, 1], off[0, 2], off[1, 0]], off[:3, 3]])
        nees.append(error @ np.linalg.solve(covariance, error))
    low, high = chi2.ppf((0.005, 0.995), 6 * n_graphs) / n_graphs
    assert 0.8 * low < np.mean(nees) < high  # what is added for shifts that err together is little here


def test_a_direction_that_edges_leave_open_is_open_in_the_covariances(rng):
    """Edges know nothing of the way along x, and as much of the rest as others."""
    graph, _ = noisy_graph(0.1, rng, LOOPS, [3])
    edges = calibrated(graph, 0.3)
    covariance = covariances(graph, edges, 0.3)[1]
    variances, axes = np.linalg.eigh(covariance[3:, 3:])
    assert np.sqrt(variances[-1]) > 1
    assert np.sqrt(variances[1]) < 0.1 * np.sqrt(variances[-1])
    assert abs((graph.poses[1][:3, :3] @ axes[:, -1])[0]) > 0.9
    assert min(local_sigmas_m(edges).values()) > 0.1


def test_how_firmly_a_keyframe_is_held_does_not_depend_on_how_far_it_is(rng):
    graph, _ = noisy_graph(0.1, rng)
    sigmas_m = local_sigmas_m(calibrated(graph, 0.1))
    middle = [sigmas_m[n] for n in range(8, N - 8)]
    assert max(middle) < 1.25 * min(middle)
    chain, _ = noisy_graph(0.1, rng, [])
    assert local_sigmas_m(calibrated(chain, 0.1))[N // 2] > 1.5 * middle[0]
