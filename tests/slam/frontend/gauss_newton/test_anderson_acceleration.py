"""Steps that lead to where an iteration comes to rest, sooner than it would by itself."""

from __future__ import annotations

import numpy as np
import pytest

from slam.frontend.gauss_newton.anderson_acceleration import FARTHEST, AndersonAcceleration

EVENLY = np.eye(2)


def came_to(steps_at, n, accelerated=True, information=EVENLY):
    """Where n steps lead from (1, 1), each of which depends on where it starts."""
    acceleration, here = AndersonAcceleration(), np.ones(2)
    for _ in range(n):
        step = steps_at(here)
        here = here + (acceleration.accelerated(step, information) if accelerated else step)
    return here


@pytest.mark.parametrize("share", [0.1, 0.5, 0.85, -0.7])
def test_of_steps_that_shrink_evenly_two_lead_there(share):
    """By themselves each leaves the same share of the way, or of what it went too far."""
    np.testing.assert_allclose(came_to(lambda here: (share - 1) * here, 2), 0, atol=1e-12)


def test_a_way_that_creeps_along_one_axis_is_shortened():
    """Fast along one axis, slow along the other: a tenth of what eight steps leave otherwise, at the most."""
    creeping = np.diag([0.2, 0.8]) - np.eye(2)
    left, otherwise = (
        np.linalg.norm(came_to(lambda here: creeping @ here, 8, accelerated)) for accelerated in (True, False)
    )
    assert left < 0.1 * otherwise


def test_what_the_information_weighs_most_decides():
    """Where sigmas of one axis are tiny, what is left along the other hardly counts."""
    uneven = np.diag([0.9, 0.2]) - np.eye(2)
    here = came_to(lambda here: uneven @ here, 2, information=np.diag([1e6, 1.0]))
    assert abs(here[0]) < 0.01
    assert abs(here[1]) > 0.1
    assert abs(came_to(lambda here: uneven @ here, 2)[0]) > 0.5


def test_the_first_step_is_as_it_was_and_a_step_of_nothing_goes_nowhere():
    acceleration, step = AndersonAcceleration(), np.array([0.3, -0.2])
    np.testing.assert_array_equal(acceleration.accelerated(step, EVENLY), step)
    resting = AndersonAcceleration()
    for _ in range(3):
        np.testing.assert_array_equal(resting.accelerated(np.zeros(2), EVENLY), 0)


def test_steps_that_hardly_change_are_extrapolated_no_farther_than_so():
    """Two that are all but the same say that the way never ends."""
    acceleration = AndersonAcceleration()
    first, second = np.array([1.0, 0.0]), np.array([0.999, 0.0])
    acceleration.accelerated(first, EVENLY)
    taken = acceleration.accelerated(second, EVENLY)
    np.testing.assert_allclose(taken, second + FARTHEST * (first + second - first))


def test_steps_that_grow_are_not_taken_backwards_beyond_where_they_began():
    """Each is twice the one before, away from where nothing is asked for: to there it is as far as it came."""
    acceleration = AndersonAcceleration()
    acceleration.accelerated(np.array([1.0, 0.0]), EVENLY)
    taken = acceleration.accelerated(np.array([2.0, 0.0]), EVENLY)
    np.testing.assert_allclose(taken, [0.0, 0.0])
