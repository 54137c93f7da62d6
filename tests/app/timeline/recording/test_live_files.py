"""Recordings that are still being written: which they are, and how they are read to their end."""

from __future__ import annotations

import threading
import time

import pytest

from app.timeline.recording.live_files import growing, is_written, live_parts, lock, recordings_at


@pytest.fixture
def part(tmp_path):
    """A part of a run that will be `run`."""
    folder = tmp_path / ".run.partial-1a2b"
    folder.mkdir()
    path = folder / "timeline.0.rrd"
    path.write_bytes(b"head")
    return path


def test_a_part_is_live_as_long_as_its_lock_is_held(part, tmp_path):
    with lock(part):
        assert is_written(part)
        assert live_parts(tmp_path / "run") == [part]
        assert recordings_at(tmp_path / "run") == [part]
    assert not is_written(part)
    assert live_parts(tmp_path / "run") == []


def test_what_a_killed_run_left_behind_does_not_hide_the_finished_one(part, tmp_path):
    (tmp_path / "run").mkdir()
    (tmp_path / "run" / "timeline.rrd").write_bytes(b"done")
    assert recordings_at(tmp_path / "run") == [tmp_path / "run" / "timeline.rrd"]
    with lock(part):  # a run that is to replace it
        assert recordings_at(tmp_path / "run") == [part]


def test_parts_come_in_the_order_in_which_they_are_read(part, tmp_path):
    second = part.with_name("timeline.1.rrd")
    second.touch()
    with lock(part), lock(second):
        assert live_parts(tmp_path / "run") == [part, second]


def test_a_recording_is_itself(tmp_path):
    (tmp_path / "compare.rrd").touch()
    assert recordings_at(tmp_path / "compare.rrd") == [tmp_path / "compare.rrd"]
    assert recordings_at(tmp_path / "missing.rrd") == []
    assert recordings_at(tmp_path / "nothing") == []


def test_a_growing_file_is_read_to_the_end_even_when_it_is_removed(part):
    def write() -> None:
        with held:
            for number in range(5):
                time.sleep(0.05)
                with part.open("ab") as file:
                    file.write(str(number).encode())
            part.unlink()

    held = lock(part)
    with part.open("rb") as file:
        writer = threading.Thread(target=write)
        writer.start()
        assert b"".join(growing(file)) == b"head01234"
    writer.join()


def test_a_whole_file_is_read_at_once(part):
    with part.open("rb") as file:
        assert list(growing(file)) == [b"head"]
