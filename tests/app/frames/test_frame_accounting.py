"""Frame accounting: used, skipped and lost frames add up, also where poses are corrected."""

from __future__ import annotations

import numpy as np

from app.frames.frame_account import FrameAccount
from app.frames.frame_accounting import FrameAccounting
from razer.frame import Frame, Intrinsics


def posed(index, stamp):
    rgb, depth = np.zeros((4, 4, 3), np.uint8), np.ones((4, 4), np.float32)
    return Frame(index, stamp, rgb, depth, Intrinsics(4, 4, 4.0, 4.0, 1.5, 1.5), np.eye(4))


def test_lost_frames_are_counted_in_intervals_until_they_come_late():
    accounting = FrameAccounting("clip", 12, 1.0)
    accounting.lost.update((0, 1, 3, 5, 6, 11))
    for index in (2, 4, 9):
        accounting.use(posed(index, index / 30))
    assert accounting.account().lost_intervals == ((0, 1), (3, 3), (5, 6), (11, 11))
    accounting.use(posed(3, 0.1))
    assert accounting.account().lost_intervals == ((0, 1), (5, 6), (11, 11))
    assert accounting.indices == [2, 3, 4, 9]
    assert accounting.stamps == sorted(accounting.stamps)
    assert accounting.account().frames == 9
    assert not accounting.notes


def test_frames_whose_pose_is_not_known_after_all_are_lost():
    accounting = FrameAccounting("clip", 4, 1.0)
    for index in range(4):
        accounting.use(posed(index, index / 30))
    accounting.correct({1: None, 2: 2 * np.eye(4)})
    assert accounting.lost == {1}
    assert accounting.indices == [0, 2, 3]
    assert accounting.stamps == [0, 2 / 30, 3 / 30]
    assert [pose[0, 0] for pose in accounting.poses] == [1, 2, 1]


def test_a_frame_counts_once_whatever_is_said_of_it_later():
    accounting = FrameAccounting("clip", 6, 1.0)
    accounting.lost.update((0, 1))
    accounting.skip(2, "torn")
    for index in (3, 4):
        accounting.use(posed(index, index / 30))
    accounting.correct({2: None, 1: np.eye(4), 3: None})  # of frames that were skipped or lost nothing is known anew
    accounting.skip(1, "its mask is torn")  # a late one that cannot be perceived
    account = accounting.account()
    assert (account.frames, account.used, account.lost, account.asked) == (5, 1, 2, 6)
    assert [one.frame for one in account.skipped] == [2, 1]
    assert account.lost_intervals == ((0, 3),)
    assert account.tracked == 1 / 6
    assert FrameAccount.from_json(account.as_json()) == account


def test_stamps_that_go_back_are_noted():
    accounting = FrameAccounting("clip", 4, 1.0)
    for index, stamp in enumerate((0.0, 0.2, 0.1, 0.1)):
        accounting.use(posed(index, stamp))
    assert list(accounting.notes.values()) == [2]
