"""Several writers and readers of one library at once, and writers that are killed."""

from __future__ import annotations

import os
import random
import signal
import subprocess
import sys
import time
from datetime import timedelta

import pytest

from app.library.map_search import MapSearch, Wanted
from app.library.tables.instance_library import InstanceLibrary
from app.library.tables.instance_rows import Entry, rows_of
from tests.app.library.test_same_as_query import ENCODER, MODEL
from tests.support.cli import environment
from tests.support.libraries import made_map

ADD = """
import sys, time
from tests.app.library.test_writers import add
uri, first, n = sys.argv[1], int(sys.argv[2]), int(sys.argv[3])
for number in range(first, first + n):
    add(uri, number)
    print(number, flush=True)
"""
READ = """
import sys, time
from tests.app.library.test_writers import counted
uri, seconds = sys.argv[1], float(sys.argv[2])
end, seen, n = time.monotonic() + seconds, 0, 0
while time.monotonic() < end:
    now = counted(uri)
    assert now >= seen, (now, seen)
    seen, n = now, n + 1
print(n)
"""
TIDY = """
import sys, datetime
from app.library.tables.instance_library import InstanceLibrary
print("begins", flush=True)
for _ in range(int(sys.argv[2])):
    InstanceLibrary(sys.argv[1]).tidy(datetime.timedelta(minutes=1))
"""
N_ROWS = rows_of(made_map(0), Entry("run", "here", 1, "{}"), MODEL).num_rows


def add(uri, number):
    entry = Entry(f"run {number}", "here", time.time_ns(), "{}")
    InstanceLibrary.made(uri, MODEL).add(rows_of(made_map(0), entry, MODEL), entry.generation)


def counted(uri) -> int:
    """How many maps a reader sees; fails where one is there in part, or an answer does not fit."""
    table = InstanceLibrary(uri).table(None)
    runs = [entry.run for entry in table.entries()]
    assert all(rows.num_rows == N_ROWS for rows in table.rows_of(runs, ("run", "generation", "id")).values())
    answer = MapSearch(table, ENCODER).by_text("chair", Wanted(3, min_score=0.0))
    assert len(answer.hits) == min(3, 14 * len(runs))
    return len(runs)


def started(code, *arguments):
    command = [sys.executable, "-c", code, *map(str, arguments)]
    return subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, env=environment())


def ended(process):
    out, err = process.communicate(timeout=300)
    assert process.returncode == 0, err[-2000:]
    return out


def test_two_who_add_the_same_run_leave_it_once(tmp_path):
    uri = str(tmp_path)
    for generation in (7, 5):  # the slower one is the older one
        entry = Entry("run", "here", generation, "{}")
        InstanceLibrary.made(uri, MODEL).table.append(rows_of(made_map(generation), entry, MODEL), generation)
    table = InstanceLibrary(uri).table(None)
    assert [entry.generation for entry in table.entries()] == [7]
    (stored,) = MapSearch(table, ENCODER).opened(["run"])
    assert stored.generation == 7
    hits = MapSearch(table, ENCODER).by_text("chair", Wanted(1000, min_score=0.0)).hits
    assert len(hits) == len({hit.hit.object.id for hit in hits})


def test_old_versions_go_and_the_newest_stays(tmp_path):
    uri = str(tmp_path)
    for number in range(4):
        add(uri, number)
    InstanceLibrary(uri).tidy(timedelta(0))
    assert counted(uri) == 4
    assert len(list(tmp_path.glob("*.lance/_versions/*.manifest"))) == 1
    assert len(list(tmp_path.glob("*.lance/data/*"))) == 1


@pytest.mark.full
def test_readers_go_on_beside_writers_and_compaction(tmp_path):
    uri = str(tmp_path)
    add(uri, 0)
    readers = [started(READ, uri, 25) for _ in range(8)]
    writers = [started(ADD, uri, 100 * i, 12) for i in (1, 2)]
    tidier = started(TIDY, uri, 4)
    for process in (*writers, tidier):
        ended(process)
    assert all(int(ended(reader)) > 0 for reader in readers)
    assert counted(uri) == 25


@pytest.mark.full
@pytest.mark.parametrize("seed", range(3))
def test_a_writer_that_is_killed_loses_nothing_that_was_there(tmp_path, seed):
    uri, rng, said = str(tmp_path), random.Random(seed), 1
    add(uri, 0)
    for attempt in range(1, 5):
        process = started(ADD, uri, 100 * attempt, 1000)
        assert process.stdout is not None
        process.stdout.readline()  # imports are over
        time.sleep(rng.uniform(0, 1))
        os.kill(process.pid, signal.SIGKILL)
        said += 1 + len(process.communicate()[0].split())
        there = counted(uri)
        assert said <= there <= said + 1  # what was being added may have been in already
        said = there
    add(uri, 1)
    assert counted(uri) == said + 1


@pytest.mark.full
@pytest.mark.parametrize("seed", range(3))
def test_a_compaction_that_is_killed_loses_nothing(tmp_path, seed):
    uri, rng = str(tmp_path), random.Random(seed)
    for number in range(12):
        add(uri, number)
    for _ in range(4):
        process = started(TIDY, uri, 1000)
        assert process.stdout is not None
        process.stdout.readline()
        time.sleep(rng.uniform(0, 0.6))
        os.kill(process.pid, signal.SIGKILL)
        process.communicate()
        assert counted(uri) == 12
    InstanceLibrary(uri).tidy(timedelta(0))
    assert counted(uri) == 12
