"""Frames come in order and bounded, and the figures of a run add up."""

from __future__ import annotations

import multiprocessing
import os
from functools import partial
from time import sleep

import numpy as np
import pytest

from app.frames.frame_accounting import FrameAccounting
from app.frames.locator import Locator
from app.frames.perceiver import Perceiver
from app.frames.prefetch_process import prefetch
from app.profiling.recorder import Recorder, summary
from razer.config import MapperConfig
from razer.errors import UnusableFrame
from razer.frame import Frame, Intrinsics
from razer.reintegration.reintegrator import Reintegrator
from razer.stages import stage

CAMERA = Intrinsics(4, 3, 5.0, 5.0, 1.5, 1.0)


def blank(index):
    return Frame(index, float(index), np.zeros((3, 4, 3), np.uint8), np.zeros((3, 4), np.float32), CAMERA)


class Clip:
    """Frames that count how often they are read; those in `broken` are unusable."""

    name, intrinsics, has_poses, depth_scale = "clip", CAMERA, False, 1.0

    def __init__(self, length, broken=(), fatal=()):
        self.length, self.broken, self.fatal, self.read = length, broken, fatal, []

    def __len__(self):
        return self.length

    def __getitem__(self, index):
        self.read.append(index)
        if index in self.broken:
            raise UnusableFrame(f"frame {index} is torn")
        if index in self.fatal:
            raise RuntimeError("bug")
        return blank(index)


class Nothing:
    """Perception that sees nothing, and says so."""

    def observe(self, frame):
        with stage("segment"):
            return frame.index


class Everywhere:
    """Poses that lose the frames in `lost`."""

    def __init__(self, lost=()):
        self.lost = lost

    def locate(self, frame):
        return None if frame.index in self.lost else np.eye(4)

    def corrections(self):
        return {}

    def report(self):
        return None


def looks(clip, indices, lost=()):
    located = prefetch(Locator(clip, partial(Everywhere, lost)), indices)
    return list(prefetch(Perceiver(Nothing()), located))


def test_looks_come_in_order_with_the_broken_and_lost_ones_named():
    found = looks(Clip(9, broken=(2, 8)), range(0, 9, 2), lost=(4,))
    assert [look.index for look in found] == [0, 2, 4, 6, 8]
    assert [look.seen for look in found] == [0, None, None, 6, None]
    assert [look.lost for look in found] == [False, False, True, False, False]
    assert found[1].reason == "frame 2 is torn"
    assert "lost" in found[2].reason


def test_a_look_carries_the_time_of_its_stages():
    found = looks(Clip(3, broken=(1,)), range(3))
    assert list(found[0].stage_ms) == ["decode", "pose", "segment"]
    assert list(found[1].stage_ms) == ["decode"]


class Note:
    """Work that leaves a file for each index it has done."""

    def __init__(self, folder):
        self.folder = folder

    def __call__(self, index):
        (self.folder / str(index)).touch()
        return index


def test_working_ahead_is_bounded(tmp_path):
    results = prefetch(Note(tmp_path), range(100), ahead=3)
    assert [next(results) for _ in range(5)] == [0, 1, 2, 3, 4]
    results.close()
    assert 5 <= len(list(tmp_path.iterdir())) <= 5 + 3


def fail_at_one(index):
    if index == 1:
        raise RuntimeError("bug")
    return index


def test_an_unknown_error_is_raised_at_its_frames_turn():
    results = prefetch(fail_at_one, range(5))
    assert next(results) == 0
    with pytest.raises(RuntimeError, match="bug"):
        next(results)


def die(index):
    os._exit(1)


def test_the_death_of_the_other_process_is_said():
    with pytest.raises(RuntimeError, match="item 0"):
        next(prefetch(die, range(5)))


def test_no_process_is_left_behind(tmp_path):
    results = prefetch(Note(tmp_path), range(50))
    next(results)
    assert len(multiprocessing.active_children()) == 1
    results.close()
    assert not multiprocessing.active_children()


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
    stage_ms = {"decode": 1.5}
    with recorder.frame(stage_ms):
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
    assert summary([1.0, 2.0, 3.0, 4.0, 100.0]) == {"median_ms": 3.0, "p95_ms": 80.8, "total_s": 0.11}
    assert summary([]) == {"median_ms": 0.0, "p95_ms": 0.0, "total_s": 0}


def posed(index, stamp):
    rgb, depth = np.zeros((4, 4, 3), np.uint8), np.ones((4, 4), np.float32)
    return Frame(index, stamp, rgb, depth, Intrinsics(4, 4, 4.0, 4.0, 1.5, 1.5), np.eye(4))


def test_lost_frames_are_told_in_runs_until_they_come_late():
    outcome = FrameAccounting("clip", 12, 1.0)
    outcome.lost.update((0, 1, 3, 5, 6, 11))
    for index in (2, 4, 9):
        outcome.use(posed(index, index / 30))
    assert outcome.lost_runs() == [(0, 1), (3, 3), (5, 6), (11, 11)]
    outcome.use(posed(3, 0.1))
    assert outcome.lost_runs() == [(0, 1), (5, 6), (11, 11)]
    assert outcome.indices == [2, 3, 4, 9]
    assert outcome.stamps == sorted(outcome.stamps)
    assert outcome.frames == 9
    assert not outcome.notes


def test_frames_whose_pose_is_not_known_after_all_are_lost():
    outcome = FrameAccounting("clip", 4, 1.0)
    for index in range(4):
        outcome.use(posed(index, index / 30))
    outcome.move({1: None, 2: 2 * np.eye(4)})
    assert outcome.lost == {1}
    assert outcome.indices == [0, 2, 3]
    assert outcome.stamps == [0, 2 / 30, 3 / 30]
    assert [pose[0, 0] for pose in outcome.poses] == [1, 2, 1]


def test_stamps_that_go_back_are_noted():
    outcome = FrameAccounting("clip", 4, 1.0)
    for index, stamp in enumerate((0.0, 0.2, 0.1, 0.1)):
        outcome.use(posed(index, stamp))
    assert list(outcome.notes.values()) == [2]


def test_of_nested_stages_the_outer_counts():
    recorder = Recorder(1, lambda: 0)
    with recorder.frame({}), stage("rebuild"), stage("integrate"):
        pass
    assert list(recorder.timings()["stages"]) == ["rebuild"]


def test_work_after_the_last_frame_is_counted_and_its_longest_pause_told():
    def work():
        for pause_s in (0.0, 0.05, 0.0):
            with stage("rebuild"):
                sleep(pause_s)
            yield 1.0

    recorder, follower = Recorder(1, lambda: 0), Reintegrator(MapperConfig())
    with recorder.frame({}), stage("rebuild"):
        pass
    assert list(recorder.afterwards(work())) == [1.0, 1.0, 1.0]
    assert recorder.timings()["frames"] == 1
    assert recorder.timings()["stages"]["rebuild"]["total_s"] >= 0.05
    figures = recorder.rebuilding(follower)
    assert 0.05 <= figures["longest_pause_s"] < 0.5
    assert 0 < figures["share"] <= 1
    assert figures["kb_per_stored_frame"] == 0
