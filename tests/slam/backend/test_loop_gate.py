"""What drift may account for: little of any way, and as much as tracking itself leaves open."""

from __future__ import annotations

import numpy as np
import pytest

from razer.geometry import inverse
from slam.backend.loop_gate import MAX_SIGMAS, is_within_uncertainty, plausible
from slam.backend.pose_graph import PoseGraph
from slam.config import LoopClosureSettings
from slam.frontend.keyframes import Keyframe
from slam.pose_edge import EDGE_SHARE, PoseEdge
from slam.se3 import exp_se3

SURE_RAD, SURE_M = 0.001, 0.003  # standard deviations of an edge
STEP = exp_se3(np.array([0, 0, 0.05, 0, 0, 1.0]))
N = 11


WAY_M = 12.0
DRIFT = LoopClosureSettings()
MOST_M, MOST_DEG = DRIFT.drift_m + WAY_M * DRIFT.drift_m_per_m, DRIFT.drift_deg + WAY_M * DRIFT.drift_deg_per_m


@pytest.mark.parametrize(
    ("shift_m", "turn_deg", "expected"),
    [
        (0.95 * MOST_M, 0.95 * MOST_DEG, True),
        (1.05 * MOST_M, 0.0, False),
        (0.0, 1.05 * MOST_DEG, False),
        (-1.05 * MOST_M, 0.95 * MOST_DEG, False),
    ],
)
@pytest.mark.parametrize("back", [False, True])
def test_what_is_farther_off_than_any_way_drifts_is_another_place(views, shift_m, turn_deg, expected, back):
    here = Keyframe(0, 0, views[10], STEP, WAY_M if back else 0.0)
    moved = exp_se3(np.array([np.radians(turn_deg), 0, 0, 0, shift_m, 0]))
    there = Keyframe(1, 0, views[10], STEP @ moved, 0.0 if back else WAY_M)
    assert plausible(here, there, np.eye(4), DRIFT) is expected


def edge(a, b, a_from_b, sigmas):
    return PoseEdge(a, b, a_from_b, np.diag(1 / np.square(sigmas) / EDGE_SHARE), is_odometry=b == a + 1)


def way(unsure=None, sigmas=(SURE_RAD,) * 3 + (SURE_M,) * 3):
    """A camera that goes a metre ahead and rolls a little at each step; much is known of all but one of them."""
    graph = PoseGraph()
    for number in range(N):
        pose = np.linalg.matrix_power(STEP, number)
        graph.add_keyframe(number, pose)
        if number:
            certain = (SURE_RAD,) * 3 + (SURE_M,) * 3
            graph.add_edge(edge(number - 1, number, STEP, sigmas if number == unsure else certain))
    return graph


def off(graph, twist, a=0, b=N - 1):
    """An edge that has a keyframe elsewhere than the graph does, by a twist along its own axes."""
    a_from_b = inverse(graph.poses[a]) @ graph.poses[b] @ exp_se3(np.array(twist))
    return edge(a, b, a_from_b, (SURE_RAD,) * 6)


def shift_m(x_m=0.0, y_m=0.0, z_m=0.0):
    return (0.0, 0.0, 0.0, x_m, y_m, z_m)


def test_where_every_step_is_known_little_is_possible():
    assert is_within_uncertainty(off(way(), shift_m()), way())
    assert not is_within_uncertainty(off(way(), shift_m(x_m=0.3)), way())


@pytest.mark.parametrize(("times", "expected"), [(0.95, True), (1.05, False)])
def test_errors_along_the_way_add_up_by_their_squares(times, expected):
    """Ahead, where turning adds nothing: ten steps."""
    sigma_m = SURE_M * np.sqrt(N - 1)
    assert is_within_uncertainty(off(way(), shift_m(z_m=times * MAX_SIGMAS * sigma_m)), way()) is expected


def test_along_the_direction_that_one_step_leaves_open_much_is_possible_and_across_it_not():
    open_ahead = way(unsure=4, sigmas=(SURE_RAD,) * 3 + (SURE_M, SURE_M, 1.0))
    assert is_within_uncertainty(off(open_ahead, shift_m(z_m=1.5)), open_ahead)
    assert not is_within_uncertainty(off(open_ahead, shift_m(z_m=2.5)), open_ahead)
    assert not is_within_uncertainty(off(open_ahead, shift_m(x_m=0.5)), open_ahead)


def test_a_turn_that_is_not_known_moves_what_comes_after_by_its_lever():
    """A turn of 0.03 radians at keyframe 3 takes the last one, seven metres on, 0.21 m aside, turned as much."""
    open_turn = way(unsure=4, sigmas=(SURE_RAD, 0.1, SURE_RAD) + (SURE_M,) * 3)
    to_end = inverse(open_turn.poses[3]) @ open_turn.poses[N - 1]
    turned = exp_se3(np.array([0, 0.03, 0, 0, 0, 0]))
    offset = inverse(to_end) @ turned @ to_end
    measured = open_turn.poses[N - 1] @ offset
    assert np.linalg.norm(offset[:3, 3]) == pytest.approx(0.21, abs=0.01)
    assert is_within_uncertainty(edge(0, N - 1, measured, (SURE_RAD,) * 6), open_turn)
    without_turn = shift_m(*offset[:3, 3])
    assert not is_within_uncertainty(off(open_turn, without_turn), open_turn)


def test_another_way_that_is_sure_counts():
    graph = way(unsure=4, sigmas=(0.1,) * 3 + (1.0,) * 3)
    assert is_within_uncertainty(off(graph, shift_m(z_m=1.0)), graph)
    graph.add_edge(off(graph, shift_m(), a=2, b=6))
    assert not is_within_uncertainty(off(graph, shift_m(z_m=1.0)), graph)


@pytest.mark.parametrize("order", [1, -1])
def test_of_two_edges_between_the_same_keyframes_the_surer_counts(order):
    graph = PoseGraph()
    for number in range(2):
        graph.add_keyframe(number, np.eye(4))
    for sigma in (0.1, 0.001)[::order]:
        graph.add_edge(edge(0, 1, np.eye(4), (sigma,) * 6))
    assert not is_within_uncertainty(off(graph, shift_m(z_m=0.1), b=1), graph)
    assert is_within_uncertainty(off(graph, shift_m(z_m=0.0015), b=1), graph)
    assert not is_within_uncertainty(off(graph, shift_m(z_m=0.0025), b=1), graph)


@pytest.mark.parametrize(("a", "b"), [(3, 5), (5, 3)])
def test_the_way_may_lead_by_later_keyframes_and_back(a, b):
    """Of the steps in between nothing is known, but both ends were measured in front of the last."""
    graph = way(unsure=4, sigmas=(0.5,) * 6)
    for number in (3, 5):
        graph.add_edge(off(graph, shift_m(), a=number))
    assert is_within_uncertainty(off(graph, shift_m(z_m=0.001), a, b), graph)
    assert not is_within_uncertainty(off(graph, shift_m(z_m=0.1), a, b), graph)


def test_numbers_may_be_left_out():
    graph = PoseGraph(fixed=3)
    for number in (3, 7):
        graph.add_keyframe(number, np.eye(4))
    assert not is_within_uncertainty(off(graph, shift_m(), 3, 7), graph)
    graph.add_edge(edge(3, 7, np.eye(4), (0.1,) * 6))
    assert is_within_uncertainty(off(graph, shift_m(z_m=0.1), 3, 7), graph)


def test_of_keyframes_that_no_way_joins_nothing_is_known():
    graph = way()
    graph.add_keyframe(N, np.eye(4), unanchored=True)
    assert not is_within_uncertainty(edge(0, N, np.eye(4), (SURE_RAD,) * 6), graph)
