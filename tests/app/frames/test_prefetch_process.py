"""Prefetching: in order, bounded, errors at their turn, and no process left behind."""

from __future__ import annotations

import multiprocessing
import os
import signal
import time
from io import StringIO
from threading import Timer

import pytest
from rich.console import Console

from app.frames.helper_wait import HelperWait
from app.frames.prefetch_process import HelperEnded, prefetch


class Note:
    """Work that leaves a file for each index it has done."""

    def __init__(self, folder):
        self.folder = folder

    def __call__(self, index):
        (self.folder / str(index)).touch()
        return index


def test_working_ahead_is_bounded(tmp_path):
    results = prefetch(Note(tmp_path), range(100), depth=3)
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
    with pytest.raises(HelperEnded, match=r"the process that finds masks ended \(exit code 1\)"):
        next(prefetch(die, range(5), does="finds masks"))


def die_at_two(index):
    if index == 2:
        os.kill(os.getpid(), signal.SIGKILL)
    return index


def test_an_item_that_ends_its_process_is_replaced_and_a_new_process_goes_on():
    results = list(prefetch(die_at_two, range(6), replacement=lambda item, how: (item, how)))
    assert [results[0], results[1], *results[3:]] == [0, 1, 3, 4, 5]
    item, how = results[2]
    assert item == 2
    assert "killed, perhaps as memory ran out" in how
    assert not multiprocessing.active_children()


def test_where_the_next_item_ends_it_too_it_is_given_up():
    results = prefetch(die, range(5), replacement=lambda item, how: how)
    next(results)
    with pytest.raises(HelperEnded):
        next(results)
    assert not multiprocessing.active_children()


def stop_at_one(index):
    if index == 1:
        time.sleep(600)
    return index


class Stop:
    requested = False


def test_work_that_never_returns_is_named_and_left_when_a_stop_is_requested():
    stop, told = Stop(), StringIO()
    waiting = HelperWait(stop, Console(file=told, width=200))
    waiting.told_after_s = (0.3,)
    results = prefetch(stop_at_one, range(5), depth=0, does="finds masks", waiting=waiting)
    assert next(results) == 0
    told.truncate(0)
    Timer(1.0, lambda: setattr(stop, "requested", True)).start()
    assert list(results) == []
    assert told.getvalue().count("waiting for the process that finds masks") == 1
    assert not multiprocessing.active_children()


def test_no_process_is_left_behind(tmp_path):
    results = prefetch(Note(tmp_path), range(50))
    next(results)
    assert len(multiprocessing.active_children()) == 1
    results.close()
    assert not multiprocessing.active_children()
