"""Profiling: the figures of a run add up."""

from __future__ import annotations

from time import sleep

import pytest

from app.profiling.map_device import MapDevice
from app.profiling.recorder import Recorder
from app.profiling.stage_summary import summarize
from razer.config import MapperConfig
from razer.reintegration.reintegrator import Reintegrator
from razer.stages import stage


def record(frames, done, blocks=lambda: 7):
    recorder = Recorder(frames, blocks)
    for index in range(done):
        with recorder.frame({"decode": 2.0 + index}):
            with stage("lift"):
                pass
            with stage("lift"):
                pass
    return recorder.timings()


@pytest.mark.parametrize(("frames", "done"), [(1, 1), (7, 7), (10, 10), (25, 25), (600, 600), (20, 5), (20, 0)])
def test_there_are_ten_samples_whatever_the_length(frames, done):
    timings = record(frames, done)
    assert timings["frames"] == done
    assert len(timings["rss_mb_at_tenths"]) == len(timings["blocks_at_tenths"]) == 10


def test_tenths_are_sampled_when_they_are_reached():
    size = iter(range(100))
    recorder = Recorder(20, lambda: next(size))
    seen = []
    for _ in range(20):
        with recorder.frame({}):
            pass
        seen.append(len(recorder._n_blocks))
    assert seen == [n // 2 for n in range(1, 21)]


def test_a_stage_entered_twice_in_a_frame_is_one_duration_of_that_frame():
    recorder = Recorder(2, lambda: 0)
    with recorder.frame({"decode": 1.5}) as stage_ms:
        with stage("lift"):
            assert stage_ms == {"decode": 1.5}
        once = stage_ms["lift"]
        with stage("lift"):
            pass
        assert stage_ms["lift"] > once
    stages = recorder.timings()["stages"]
    assert list(stages) == ["decode", "lift"]
    assert stages["decode"] == {"median_ms": 1.5, "p95_ms": 1.5, "total_s": 0.0015}


def test_stages_outside_a_frame_are_not_counted():
    recorder = Recorder(1, lambda: 0)
    with stage("lift"):
        pass
    assert recorder.timings()["stages"] == {}


def test_a_stage_that_raises_is_still_counted():
    recorder = Recorder(1, lambda: 0)
    with pytest.raises(KeyError), recorder.frame({}), stage("pose"):
        raise KeyError
    assert "pose" in recorder.timings()["stages"]


def test_summary_of_known_durations():
    assert summarize([1.0, 2.0, 3.0, 4.0, 100.0]) == {"median_ms": 3.0, "p95_ms": 80.8, "total_s": 0.11}
    assert summarize([]) == {"median_ms": 0.0, "p95_ms": 0.0, "total_s": 0}


def test_of_nested_stages_the_outer_counts():
    recorder = Recorder(1, lambda: 0)
    with recorder.frame({}), stage("rebuild"), stage("integrate"):
        pass
    assert list(recorder.timings()["stages"]) == ["rebuild"]


def test_work_after_the_last_frame_is_counted_and_its_longest_pause_reported():
    def work():
        for pause_s in (0.0, 0.05, 0.0):
            with stage("rebuild"):
                sleep(pause_s)
            yield 1.0

    recorder, reintegrator = Recorder(1, lambda: 0), Reintegrator(MapperConfig())
    with recorder.frame({}), stage("rebuild"):
        pass
    assert list(recorder.afterwards(work())) == [1.0, 1.0, 1.0]
    assert recorder.timings()["frames"] == 1
    assert recorder.timings()["stages"]["rebuild"]["total_s"] >= 0.05
    figures = recorder.rebuilding(reintegrator)
    assert 0.05 <= figures["longest_pause_s"] < 0.5
    assert 0 < figures["share"] <= 1
    assert figures["kb_per_stored_frame"] == 0


def test_a_stage_lasts_until_its_device_is_done():
    class Busy(MapDevice):
        def wait(self) -> None:
            sleep(0.05)

    recorder = Recorder(1, lambda: 0, Busy())
    with recorder.frame({}), stage("vote"):
        pass
    assert recorder.timings()["stages"]["vote"]["median_ms"] >= 50
