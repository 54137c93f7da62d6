"""Publishing a run: within its share of the time, and whoever reads cannot hold it up."""

from __future__ import annotations

import pickle
import threading
import time
from multiprocessing import Pipe
from pathlib import Path

import pytest

from app.live import publisher as publishing
from app.live.publisher import Publisher
from app.live.snapshot import Finished, Snapshot
from app.settings.run_config import RunConfig
from data_tools.synthetic.synthetic_room import SyntheticRoom
from razer.config import VoxelSettings
from razer.mapper import Mapper


@pytest.fixture(scope="module")
def steps():
    """A mapper, and what its frames and steps were."""
    config = RunConfig(voxels=VoxelSettings(voxel_size_m=0.05))
    mapper = Mapper(config, "geometric", "appearance")
    room = SyntheticRoom(n_frames=4, width=160, height=120)
    return mapper, [(room[index], mapper.step(room[index])) for index in range(4)]


def shown(publisher: Publisher, steps) -> None:
    mapper, frames = steps
    for frame, step in frames:
        publisher.show(frame, step, mapper)


def received(pipe, n: int) -> list:
    return [pickle.loads(pipe.recv_bytes()) for _ in range(n) if pipe.poll(5)]


def test_the_first_frame_is_published_at_once_and_the_next_wait(steps):
    reader, writer = Pipe(duplex=False)
    shown(Publisher(writer), steps)
    (first,) = received(reader, 1)
    assert isinstance(first, Snapshot)
    assert first.frame == 0
    assert first.chunks
    assert not reader.poll(0.2)


def test_what_was_left_out_comes_with_the_next(steps, monkeypatch):
    monkeypatch.setattr(publishing, "TIME_SHARE", 1e9)
    reader, writer = Pipe(duplex=False)
    publisher = Publisher(writer)
    for _ in range(3):
        shown(publisher, steps)
        time.sleep(0.05)
    chunks = set()
    while reader.poll(0.5):
        chunks |= pickle.loads(reader.recv_bytes()).chunks.keys()
    publisher_due = publisher._due
    assert chunks == publisher_due._taken.keys()


def test_a_reader_that_reads_nothing_holds_up_no_frame(steps, monkeypatch):
    monkeypatch.setattr(publishing, "TIME_SHARE", 1e9)
    _, writer = Pipe(duplex=False)
    publisher = Publisher(writer)
    done = threading.Event()

    def run() -> None:
        for _ in range(20):
            shown(publisher, steps)
        done.set()

    threading.Thread(target=run, daemon=True).start()
    assert done.wait(30)


def test_a_reader_that_is_gone_ends_publishing_and_nothing_else(steps, monkeypatch):
    monkeypatch.setattr(publishing, "TIME_SHARE", 1e9)
    reader, writer = Pipe(duplex=False)
    reader.close()
    publisher = Publisher(writer)
    shown(publisher, steps)
    deadline_s = time.monotonic() + 5
    while not publisher._is_gone and time.monotonic() < deadline_s:
        time.sleep(0.01)
    shown(publisher, steps)
    publisher.finish(Finished(Path("run")))
    assert publisher._is_gone


def test_the_end_comes_after_all_that_waits(steps):
    reader, writer = Pipe(duplex=False)
    publisher = Publisher(writer)
    shown(publisher, steps)
    publisher.finish(Finished(Path("run")))
    kinds = [type(message) for message in received(reader, 2)]
    assert kinds == [Snapshot, Finished]
