"""Errors that go together add up to more: the growth of variance against drawn errors, and by a graph."""

from __future__ import annotations

import numpy as np
import pytest

from slam.backend.pose_graph import PoseGraph
from slam.pose_edge import PoseEdge
from slam.uncertainty.correlated_errors import SHARED_VIEW, error_growth, growth


@pytest.mark.parametrize("n", [1, 2, 3, 8, 40])
def test_the_variance_of_a_sum_is_that_of_all_its_covariances(n):
    away = np.abs(np.subtract.outer(np.arange(n), np.arange(n)))
    assert growth(np.array([float(n)]))[0] == pytest.approx((SHARED_VIEW**away).sum() / n)


def test_registrations_that_share_a_view_correlate_by_a_half(rng):
    """Each errs by the difference of what the errors of its two views are, those of which go on by half."""
    views = rng.normal(size=(20000, 3))
    errors = views[:, :2] + views[:, 1:]
    assert np.corrcoef(errors.T)[0, 1] == pytest.approx(SHARED_VIEW, abs=0.02)


def graph_of(pairs, n, fixed=0):
    graph = PoseGraph(fixed)
    for number in range(n):
        graph.add_keyframe(number, np.eye(4))
    for a, b in pairs:
        graph.add_edge(PoseEdge(a, b, np.eye(4), np.eye(6)))
    return graph


def test_a_keyframe_is_as_far_from_the_world_as_the_shortest_way_of_edges():
    chain = graph_of([(0, 1), (1, 2), (2, 3), (3, 4)], 6)
    expected = growth(np.array([1, 1, 2, 3, 4, np.inf]))
    np.testing.assert_allclose(error_growth(chain), expected)
    assert expected[-1] == pytest.approx(3)
    chain.add_edge(PoseEdge(0, 4, np.eye(4), np.eye(6)))
    np.testing.assert_allclose(error_growth(chain), growth(np.array([1, 1, 2, 2, 1, np.inf])))


def test_where_priors_say_where_the_world_is_errors_are_taken_to_have_grown_all_they_may():
    np.testing.assert_allclose(error_growth(graph_of([(0, 1)], 2, None)), 3)


def test_a_graph_without_keyframes_has_none():
    assert error_growth(PoseGraph()).shape == (0,)
