"""False ties are counted, true ones and drift are not."""

from __future__ import annotations

from types import SimpleNamespace

import numpy as np
import pytest

from app.benchmark.poses.false_ties import MergeWatch, count_false_edges
from app.benchmark.poses.motion_error import MAX_OFF_DEG, MAX_OFF_M
from razer.geometry import inverse
from slam.pose_edge import PoseEdge
from slam.se3 import exp_se3

FRAMES = [3, 7, 20]
TRUTH = {frame: exp_se3(np.array([0.1 * frame, 0, 0.2, frame, 2, -1.0])) for frame in FRAMES}


def edge(a: int, b: int, off: np.ndarray, is_odometry: bool = False) -> PoseEdge:
    true = inverse(TRUTH[FRAMES[a]]) @ TRUTH[FRAMES[b]]
    return PoseEdge(a, b, true @ exp_se3(off), np.eye(6), is_odometry)


def off(turn_deg: float = 0.0, shift_m: float = 0.0) -> np.ndarray:
    return np.array([0, np.radians(turn_deg), 0, 0, 0, shift_m])


def test_edges_beyond_either_bound_are_false():
    near = [edge(0, 1, off(0.99 * MAX_OFF_DEG)), edge(1, 2, off(0, 0.99 * MAX_OFF_M))]
    far = [edge(0, 1, off(1.01 * MAX_OFF_DEG)), edge(0, 2, off(0, -1.01 * MAX_OFF_M), is_odometry=True)]
    assert count_false_edges(near, FRAMES, TRUTH) == 0
    assert count_false_edges([*near, *far], FRAMES, TRUTH) == 2


def keyframes(*places: tuple[int, float, float]) -> tuple[list, dict]:
    """Keyframes given as (submap, true x, estimated x), numbered as they come; and the truth."""
    made, truth = [], {}
    for number, (submap, true, estimated) in enumerate(places):
        truth[number] = exp_se3(np.array([0, 0, 0, true, 0, 0]))
        pose = exp_se3(np.array([0, 0, 0, estimated, 0, 0]))
        made.append(SimpleNamespace(submap=submap, world_from_camera=pose, view=SimpleNamespace(index=number)))
    return made, truth


def merged(before: tuple, after: tuple) -> int:
    watch = MergeWatch()
    watch.see(*keyframes(*before))
    watch.see(*keyframes(*after))
    return watch.n_false


APART = ((0, 0.0, 10.0), (0, 1.0, 11.0), (1, 1.5, 0.0))


@pytest.mark.parametrize(("estimated", "n_false"), [(11.5, 0), (11.75, 0), (12.0, 1), (10.0, 1)])
def test_a_merge_is_judged_by_where_it_puts_the_submap(estimated, n_false):
    assert merged(APART, (*APART[:2], (0, 1.5, estimated))) == n_false


def test_drift_along_the_way_makes_no_merge_false():
    """Of a long way that is 1 m too long, the end is where its neighbours are."""
    way = tuple((0, float(n), 1.1 * n) for n in range(11))
    assert merged((*way, (1, 10.2, 0.0)), (*way, (0, 10.2, 11.2))) == 0


def test_a_merge_is_true_where_its_other_end_has_drifted():
    """A loop tied together at one end, whose two halves do not quite meet at the other."""
    half, drifted = tuple((0, float(n), float(n)) for n in range(11)), ((5.2, 5.2), (10.1, 11.1))
    assert merged((*half, *((1, x, 0.0) for x, _ in drifted)), (*half, *((0, *one) for one in drifted))) == 0


def test_submaps_that_change_their_numbers_are_not_merged():
    renamed = tuple((1 - submap, true, estimated) for submap, true, estimated in APART)
    assert merged(APART, renamed) == 0
    grown = (*APART, (1, 9.0, 0.0), (2, 20.0, 0.0))
    assert merged(APART, grown) == 0


def test_each_of_several_submaps_that_are_merged_counts():
    before = (*APART, (2, 2.0, 0.0))
    assert merged(before, (*APART[:2], (0, 1.5, 15.0), (0, 2.0, 16.0))) == 2
    assert merged(before, (*APART[:2], (0, 1.5, 11.5), (0, 2.0, 16.0))) == 1
