"""How long a lost camera takes to be found again: counted on made-up walks."""

from __future__ import annotations

import numpy as np
import pytest

from app.benchmark.poses.recovery import MIN_KNOWN, RecoveryWatch

HERE, THERE = np.arange(10), np.arange(100, 110)  # cells of two places
HALF = np.concatenate([HERE[:5], THERE[:5]])
BLIND, LOST = None, None


def at(x: float) -> np.ndarray:
    pose = np.eye(4)
    pose[0, 3] = x
    return pose


def watched(*shots: tuple) -> RecoveryWatch:
    """Shots are (cells, true x, estimated x or None)."""
    watch, poses, truth = RecoveryWatch(), {}, {}
    for frame, (cells, true, estimated) in enumerate(shots):
        if cells is not None:
            truth[frame] = at(true)
        if estimated is not None:
            poses[frame] = at(estimated)
        watch.see(frame, cells, poses, truth)
    return watch


def test_a_camera_that_is_never_lost_takes_no_frames():
    watch = watched((HERE, 0, 7), (HERE, 1, 8), (THERE, 2, 9))
    assert (watch.frames_to_recover, watch.longest) == ([], 0)


@pytest.mark.parametrize("late", [0, 1, 4])
def test_frames_count_from_the_first_that_shows_what_is_known(late):
    blind, unknown = [(BLIND, 0, LOST)] * 3, [(THERE, 5, LOST)] * 6
    watch = watched((HERE, 0, 0), *blind, *unknown, *[(HERE, 0, LOST)] * late, (HERE, 0, 0))
    assert (watch.frames_to_recover, watch.longest) == ([late], late)


def test_what_was_seen_while_lost_is_known_only_afterwards():
    first = (HERE, 0, 0), (BLIND, 0, LOST), (THERE, 5, LOST), (THERE, 5, LOST), (HALF, 5, 5)
    again = (BLIND, 0, LOST), (THERE, 5, LOST), (THERE, 5, LOST), (THERE, 5, 5)
    assert watched(*first, *again).frames_to_recover == [0, 2]


def test_frames_count_on_where_the_known_goes_out_of_view_again():
    watch = watched((HERE, 0, 0), (HERE, 0, LOST), (THERE, 5, LOST), (BLIND, 5, LOST), (THERE, 5, LOST), (HERE, 0, 0))
    assert watch.frames_to_recover == [3]


def test_a_view_of_which_less_is_known_does_not_count():
    few = round(MIN_KNOWN * 10) - 1
    mostly_new = np.concatenate([HERE[:few], THERE[few:]])
    watch = watched((HERE, 0, 0), (mostly_new, 0, LOST), (mostly_new, 0, LOST), (HERE, 0, 0))
    assert watch.frames_to_recover == [0]
    enough = np.concatenate([HERE[: few + 1], THERE[few + 1 :]])
    assert watched((HERE, 0, 0), (enough, 0, LOST), (enough, 0, LOST), (HERE, 0, 0)).frames_to_recover == [2]


def test_a_pose_at_another_place_is_no_recovery():
    watch = watched((HERE, 0, 7), (BLIND, 0, LOST), (HERE, 0, 9), (HERE, 0, 7.31), (HERE, 0, 7.29))
    assert watch.frames_to_recover == [2]


def test_a_camera_that_is_never_found_again_has_no_number():
    found_once = (HERE, 0, 0), (BLIND, 0, LOST), (HERE, 0, 0)
    assert watched(*found_once, (BLIND, 0, LOST), (HERE, 0, LOST)).longest is None
    # Nobody can be found where nothing is known.
    assert watched(*found_once, (BLIND, 0, LOST), (THERE, 0, LOST)).longest == 0


def test_poses_that_are_corrected_are_compared_as_they_are_then():
    watch, truth = RecoveryWatch(), {n: at(n) for n in range(3)}
    watch.see(0, HERE, {0: at(0)}, truth)
    watch.see(1, None, {0: at(0)}, truth)
    watch.see(2, HERE, {0: at(3), 2: at(5)}, truth)
    assert watch.frames_to_recover == [0]


def test_what_comes_before_the_first_pose_is_no_loss():
    assert watched((HERE, 0, LOST), (HERE, 0, LOST), (HERE, 0, 0)).frames_to_recover == []
