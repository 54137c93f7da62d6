"""Processor time beside plain fusion's: of made-up times the figures, of true work what it took."""

from __future__ import annotations

import pytest

from app.benchmark.poses.processor_time import ProcessorTime
from data_tools.synthetic.synthetic_room import SyntheticRoom


def test_figures_of_made_up_times():
    time = ProcessorTime(frames_s=[0.01] * 18 + [0.04] * 2, end_s=0.14, plain_ms=[5.0] * 15 + [25.0] * 5)
    assert time.figures() == pytest.approx({"cpu_ms": 20.0, "to_plain": 2.0, "p95_to_plain": 8.0, "end_share": 0.35})


def test_a_walk_that_shows_nothing_has_figures():
    figures = ProcessorTime(frames_s=[0.01]).figures()
    assert figures["cpu_ms"] == 10
    assert figures["end_share"] == 0


def test_work_is_done_and_counted_once():
    time, room = ProcessorTime(), SyntheticRoom(1, 2, 64, 48)
    assert time.of_frame(lambda: sum(range(2_000_000))) == 1_999_999_000_000
    assert time.of_end(lambda: "end") == "end"
    time.fuse(room[0], room[0].pose)
    assert len(time.frames_s) == len(time.plain_ms) == 1
    assert time.frames_s[0] > time.end_s > 0
    assert time.plain_ms[0] > 0
