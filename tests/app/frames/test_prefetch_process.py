"""Prefetching: in order, bounded, errors at their turn, and no process left behind."""

from __future__ import annotations

import multiprocessing
import os

import pytest

from app.frames.prefetch_process import prefetch


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
    with pytest.raises(RuntimeError, match="item 0"):
        next(prefetch(die, range(5)))


def test_no_process_is_left_behind(tmp_path):
    results = prefetch(Note(tmp_path), range(50))
    next(results)
    assert len(multiprocessing.active_children()) == 1
    results.close()
    assert not multiprocessing.active_children()
