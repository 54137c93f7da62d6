"""How far given poses are to be believed, measured from planted errors; and what priors do to a pose graph."""

from __future__ import annotations

import numpy as np
import pytest

from razer.geometry import inverse
from slam.backend.given_uncertainty import MIN_SIGMA_M, GivenUncertainty
from slam.backend.pose_graph import PoseGraph
from slam.pose_edge import EDGE_SHARE, PoseEdge, PosePrior
from slam.refinement_settings import RefinementSettings
from slam.se3 import exp_se3, length_m
from tests.support.drifting_poses import drifting, noisy
from tests.support.pose_files import curved_path

EDGE_SIGMA_M = 0.001  # of planted registrations, along each axis, and as many radians
UNIT = 0.05  # by how many of the sigmas that they are given these are off
N = 60


def edges_of(truth, rng):
    """Registrations of each keyframe to the three before it, and to the one of twenty steps before."""
    pairs = [(b - k, b) for b in range(len(truth)) for k in (1, 2, 3) if b >= k]
    pairs += [(b - 20, b) for b in range(20, len(truth))]
    information = np.eye(6) / (EDGE_SIGMA_M / UNIT) ** 2 / EDGE_SHARE
    return [
        PoseEdge(
            a,
            b,
            exp_se3(rng.normal(0, EDGE_SIGMA_M, 6)) @ inverse(truth[a]) @ truth[b],
            information,
            is_odometry=b - a == 1,
        )
        for a, b in pairs
    ]


def measured(given, truth, rng):
    by_number = dict(enumerate(given))
    before = GivenUncertainty.of(RefinementSettings())
    return before.measured(by_number, edges_of(truth, rng), dict(enumerate(truth)))


@pytest.fixture
def truth():
    return curved_path(N, 0.1)


def test_true_poses_are_believed_wholly(truth, rng):
    uncertainty = measured(truth, truth, rng)
    assert uncertainty.step_m < 2 * MIN_SIGMA_M
    assert uncertainty.absolute_m < 0.005


def test_noise_is_measured_and_is_not_taken_for_drift(truth, rng):
    uncertainty = measured(noisy(truth, rng, 0.01, 0.2), truth, rng)
    assert uncertainty.step_m == pytest.approx(0.01 * np.sqrt(2), rel=0.35)  # both ends of a step are off
    assert uncertainty.absolute_m < 0.04


def test_drift_is_believed_from_step_to_step_and_not_in_the_long_run(truth, rng):
    given = drifting(truth, 0.02, 2.0)
    uncertainty = measured(given, truth, rng)
    end_m = length_m(inverse(given[-1]) @ truth[-1])
    assert uncertainty.step_m < 0.1 * end_m
    assert uncertainty.absolute_m > 0.3 * end_m


def test_too_few_registrations_leave_what_was_assumed(truth, rng):
    before = GivenUncertainty.of(RefinementSettings())
    assert before.measured(dict(enumerate(truth)), edges_of(truth, rng)[:4], dict(enumerate(truth))) == before


@pytest.mark.parametrize(("n_across", "jump_stays"), [(1, True), (12, False)])
def test_a_jump_of_given_poses_is_let_go_where_several_registrations_say_so(n_across, jump_stays, truth, rng):
    """One registration across it that tells little may have slid; twelve that tell much have not."""
    jump = exp_se3(np.array([0.0, 0.0, 0.0, 0.2, 0.0, 0.0]))
    given = [*truth[:30], *(jump @ pose for pose in truth[30:])]
    uncertainty = GivenUncertainty(0.001, 0.05, 1.0, 20.0, UNIT)
    graph = PoseGraph(fixed=None)
    for number in range(N):
        graph.add_keyframe(number, given[number])
        for prior in uncertainty.priors(dict(enumerate(given)), number, number - 1 if number else None):
            graph.add_prior(prior)
    weak = 0.1 if n_across == 1 else 1.0
    information = weak**2 * np.eye(6) / (EDGE_SIGMA_M / UNIT) ** 2 / EDGE_SHARE
    for k in range(n_across):
        graph.add_edge(PoseEdge(29 - k, 30, inverse(truth[29 - k]) @ truth[30], information, is_odometry=k == 0))
    poses = graph.smooth()
    step = inverse(poses[29]) @ poses[30]
    off_m = length_m(inverse(inverse(truth[29]) @ truth[30]) @ step)
    assert (off_m > 0.15) == jump_stays
    assert (off_m < 0.02) == (not jump_stays)


def test_priors_alone_say_where_the_world_is(truth):
    graph = PoseGraph(fixed=None)
    for number in range(4):
        graph.add_keyframe(number, np.eye(4))
        graph.add_prior(PosePrior(None, number, truth[number], np.full(6, 0.1), 1.0))
    poses = graph.optimise()
    for number in range(4):
        np.testing.assert_allclose(poses[number], truth[number], atol=1e-3)
