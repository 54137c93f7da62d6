"""Simulated batches against schedules that are known."""

from __future__ import annotations

import numpy as np
import pytest

from app.batch.simulation.discrete_events import Cluster, simulate


@pytest.mark.parametrize(
    ("seconds", "workers", "makespan_s"),
    [
        ([7.0], 1, 7.0),
        ([3.0, 1.0, 2.0], 1, 6.0),
        ([3.0, 3.0, 2.0, 2.0, 2.0], 2, 7.0),  # Graham's example: the longest first is not the best, which is 6
        ([5.0, 1.0], 10, 5.0),
    ],
)
def test_small_batches_end_as_they_do_on_paper(seconds, workers, makespan_s):
    made = simulate(seconds, Cluster(workers))
    assert made.makespan_s == makespan_s
    assert made.busy == pytest.approx(sum(seconds) / (workers * makespan_s))
    assert (made.lost, made.failed) == (0, 0)


def test_no_schedule_is_below_the_bound_nor_the_longest_first_far_above():
    """Graham (1969): at most 4/3 - 1 / 3m of the best."""
    rng = np.random.default_rng(1)
    for workers in (2, 7, 40):
        made = simulate(rng.lognormal(3, 1, 200), Cluster(workers))
        assert 1 <= made.over_bound <= 4 / 3


def test_handing_out_one_after_the_other_bounds_many_workers():
    made = simulate(np.full(1000, 10.0), Cluster(1000, dispatch_s=0.1))
    assert made.makespan_s == pytest.approx(1000 * 0.1 + 10)


def test_stragglers_take_longer_by_their_share():
    made = simulate(np.full(20_000, 10.0), Cluster(1, straggler_share=0.1, straggler_times=3.0))
    assert made.makespan_s == pytest.approx(20_000 * 10 * 1.2, rel=0.02)


def test_scenes_of_nodes_that_die_are_tried_three_times():
    """A scene of an hour where a node lives for an hour on average is done with a chance of 1 / e each time."""
    chance = np.exp(-1)
    made = simulate(np.full(20_000, 3600.0), Cluster(1000, hours_between_failures=1.0, restart_s=0.0), seed=4)
    assert made.failed / 20_000 == pytest.approx((1 - chance) ** 3, rel=0.05)
    assert made.lost / 20_000 == pytest.approx((1 - chance) + (1 - chance) ** 2 + (1 - chance) ** 3, rel=0.05)


def test_what_was_lost_is_seldom_where_nodes_live_long():
    made = simulate(np.full(5000, 60.0), Cluster(100, hours_between_failures=1.0), seed=1)
    assert made.failed == 0
    assert made.lost == pytest.approx(5000 * 60 / 3600, rel=0.3)


def test_a_seed_is_one_course_of_events():
    cluster = Cluster(10, straggler_share=0.1, hours_between_failures=1.0)
    one, same, other = (simulate(np.full(300, 60.0), cluster, seed) for seed in (1, 1, 2))
    assert one == same
    assert one != other
