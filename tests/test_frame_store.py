"""Kept frames are small and come back as they went in; what memory cannot hold goes to a file that leaves no trace."""

from __future__ import annotations

import subprocess
import sys

import numpy as np
import pytest
from depth_scenes import CAMERA

from data_tools.worlds.synthetic import SyntheticRoom
from razer.cells import ObservedSurface
from razer.frame import Frame
from razer.frame_packing import pack, unpack
from razer.frame_store import FrameStore


def seen(frame: Frame) -> ObservedSurface:
    return ObservedSurface.of(frame, 0.02, 0.1, 5.0)


@pytest.fixture(scope="module")
def room_frame() -> Frame:
    return SyntheticRoom(seed=1, n_frames=30, noise=True)[7]


def test_a_frame_comes_back_within_the_error_of_a_sensor_and_its_ids_exactly(room_frame: Frame) -> None:
    surface = seen(room_frame)
    assert surface.stride == 2
    ids = room_frame.instance_ids[::2, ::2].copy()
    packed = pack(room_frame, surface, ids)
    assert len(packed) < 150_000
    replay = unpack(packed, 7)
    assert replay.frame.index == 7
    assert (replay.ids == ids).all()
    back, depth = replay.frame.depth, surface.depth
    assert ((back > 0) == (depth > 0)).all()
    assert (np.abs(back - depth) <= 0.00026 * depth**2 + 1e-6).all()
    assert np.abs(replay.frame.rgb.astype(int) - room_frame.rgb[::2, ::2]).mean() < 5


def test_a_replayed_frame_shows_the_cells_it_showed_at_first(room_frame: Frame) -> None:
    surface = seen(room_frame)
    replay = unpack(pack(room_frame, surface, np.zeros(surface.depth.shape, np.int32)), 7)
    again = seen(replay.frame.at(room_frame.pose))
    assert again.stride == 1
    np.testing.assert_allclose(again.matrix, surface.matrix)
    first, second = ({tuple(c) for c in s.cells.coordinates.tolist()} for s in (surface, again))
    assert len(first & second) > 0.85 * len(first | second)


@pytest.mark.parametrize("largest_id", [0, 3, 70_000, 2**31 - 1])
def test_ids_and_depth_at_the_edges_of_their_range(largest_id: int) -> None:
    depth = np.zeros((CAMERA.height, CAMERA.width), np.float32)
    depth[::3], depth[1::3] = 5.0, 0.1
    frame = Frame(0, 0.0, np.zeros((*depth.shape, 3), np.uint8), depth, CAMERA, np.eye(4))
    surface = seen(frame)
    ids = np.full(surface.depth.shape, largest_id, np.int32)
    replay = unpack(pack(frame, surface, ids), 0)
    assert (replay.ids == largest_id).all()
    np.testing.assert_allclose(replay.frame.depth, surface.depth, rtol=0.0013)


def test_beyond_the_limit_frames_go_to_a_file_and_come_back_in_order() -> None:
    store = FrameStore(memory_limit_bytes=250)
    frames = [bytes([i]) * (60 + i) for i in range(10)]
    for i, packed in enumerate(frames):
        store.append(packed)
        assert store[i // 2] == frames[i // 2]
    assert len(store) == 10
    assert store.memory_bytes <= 250
    assert store.spilled_bytes == sum(map(len, frames)) - store.memory_bytes
    assert [store[i] for i in range(10)] == frames


@pytest.mark.parametrize("ending", ["pass", "raise KeyboardInterrupt", "os.kill(os.getpid(), 9)"])
def test_however_a_run_ends_no_file_is_left(tmp_path, ending: str) -> None:
    source = (
        "import os\nfrom razer.frame_store import FrameStore\n"
        "store = FrameStore(0)\nstore.append(b'x' * 100_000)\nassert store.spilled_bytes == 100_000\n" + ending
    )
    environment = {"TMPDIR": str(tmp_path), "PATH": "", "PYTHONPATH": ":".join(sys.path)}
    subprocess.run([sys.executable, "-c", source], env=environment, capture_output=True, check=False)
    assert list(tmp_path.iterdir()) == []
