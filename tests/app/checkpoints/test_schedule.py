"""Checkpoints come after so many frames, or by time within their share of it."""

from __future__ import annotations

from app.checkpoints.schedule import EVERY_S, MAX_SHARE, CheckpointSchedule


class Clock:
    def __init__(self):
        self.now_s = 0.0

    def __call__(self):
        return self.now_s


def test_every_so_many_frames():
    schedule = CheckpointSchedule(5)
    due = []
    for n in range(1, 17):
        if schedule.is_due(n):
            due.append(n)
            schedule.note_cost(100.0)
    assert due == [5, 10, 15]


def test_never():
    assert not any(CheckpointSchedule(0, lambda: 1e9).is_due(n) for n in range(100))


def test_by_time_none_is_due_while_another_is_under_way():
    clock = Clock()
    schedule = CheckpointSchedule(None, clock)
    clock.now_s = EVERY_S
    assert schedule.is_due(1)
    clock.now_s = 3 * EVERY_S
    assert not schedule.is_due(2)
    schedule.note_cost(0.1)
    assert not schedule.is_due(3)
    clock.now_s = 4 * EVERY_S
    assert schedule.is_due(4)


def run(cost_s, frame_s=0.1, hours=2.0):
    """The share of the time that checkpoints of a cost take, and the longest time without one."""
    clock = Clock()
    schedule, spent_s, longest_s, last_s, n = CheckpointSchedule(None, clock), 0.0, 0.0, 0.0, 0
    while clock.now_s < 3600 * hours:
        clock.now_s += frame_s
        n += 1
        if schedule.is_due(n):
            clock.now_s += cost_s
            spent_s += cost_s
            longest_s, last_s = max(longest_s, clock.now_s - last_s), clock.now_s
            schedule.note_cost(cost_s)
    return spent_s / clock.now_s, longest_s


def test_cheap_ones_come_every_minute():
    share, longest_s = run(cost_s=0.5)
    assert share < MAX_SHARE
    assert longest_s < EVERY_S + 1


def test_dear_ones_come_more_rarely_and_keep_their_share():
    for cost_s in (5.0, 20.0):
        share, _ = run(cost_s)
        assert 0 < share <= MAX_SHARE
