"""Kept frames are small and come back as they went in; what memory cannot hold goes to a file that leaves no trace."""

from __future__ import annotations

import subprocess
import sys
from dataclasses import replace

import numpy as np
import pytest

from data_tools.synthetic.synthetic_room import SyntheticRoom
from razer.config import MapperConfig, VoxelSettings
from razer.detection.lifting import Lifted
from razer.detection.observed_surface import ObservedSurface
from razer.detection.perception import Observation, Perception
from razer.frame import Frame
from razer.models.oracle.embedder import OracleEmbedder
from razer.models.oracle.segmenter import OracleSegmenter
from razer.reintegration.frame_codec import pack, unpack
from razer.reintegration.frame_store import FrameStore
from tests.support.depth_scenes import CAMERA
from tests.support.scenes import pose

SETTINGS = VoxelSettings()


def observed(frame: Frame, noise: str = "none") -> Observation:
    perception = Perception(MapperConfig(), OracleSegmenter(noise, seed=2), OracleEmbedder("full", seed=2))
    return perception.observe(frame)


def bare(frame: Frame) -> Observation:
    surface = ObservedSurface.of(frame, SETTINGS.voxel_size_m, SETTINGS.depth_min_m, SETTINGS.depth_max_m)
    return Observation(frame, surface, Lifted((), np.zeros(0, np.int32), np.zeros(0, np.int32)))


@pytest.fixture(scope="module")
def room_frame() -> Frame:
    return SyntheticRoom(seed=1, n_frames=30, noise=True)[7]


@pytest.fixture(scope="module")
def observation(room_frame: Frame) -> Observation:
    return observed(room_frame, "full")


def test_a_frame_comes_back_within_the_error_of_a_sensor(room_frame: Frame, observation: Observation) -> None:
    assert observation.surface.stride == 2
    packed = pack(observation)
    assert len(packed) < 150_000
    unpacked = unpack((packed, room_frame.pose), SETTINGS)
    assert (unpacked.frame.index, unpacked.frame.stamp) == (7, room_frame.stamp)
    back, depth = unpacked.frame.depth, observation.surface.depth
    assert ((back > 0) == (depth > 0)).all()
    assert (np.abs(back - depth) <= 0.00026 * depth**2 + 1e-6).all()
    assert np.abs(unpacked.frame.rgb.astype(int) - room_frame.rgb[::2, ::2]).mean() < 5


def test_a_frame_that_comes_back_shows_the_cells_it_showed_at_first(
    room_frame: Frame, observation: Observation
) -> None:
    unpacked = unpack((pack(observation), room_frame.pose), SETTINGS).surface
    assert unpacked.stride == 1
    np.testing.assert_allclose(unpacked.matrix, observation.surface.matrix)
    first, second = ({tuple(c) for c in s.cells.coordinates.tolist()} for s in (observation.surface, unpacked))
    assert len(first & second) > 0.85 * len(first | second)


def test_detections_come_back_as_they_were_and_lie_where_the_new_pose_puts_them(observation: Observation) -> None:
    moved = pose((1.0, -2.0, 0.5)) @ observation.frame.pose
    unpacked = unpack((pack(observation), moved), SETTINGS)
    first, second = observation.lifted.detections, unpacked.lifted.detections
    assert len(first) == len(second) > 5
    for one, other in zip(first, second, strict=True):
        assert (one.mask, one.score, one.quality, one.class_name) == (
            other.mask,
            other.score,
            other.quality,
            other.class_name,
        )
        assert (one.pixels == other.pixels).all()
        assert one.sector == other.sector  # the pose is moved, not turned
        assert one.embedding @ other.embedding > 0.9999
        np.testing.assert_allclose(other.moments.mean - one.moments.mean, (1.0, -2.0, 0.5), atol=0.01)
        assert other.n_cells == pytest.approx(one.n_cells, rel=0.15, abs=5)


def test_masks_too_small_for_a_detection_still_tell_whom_they_lay_over(observation: Observation) -> None:
    """The first detection is taken away, and its cells are left as members of its mask."""
    first, *others = observation.lifted.detections
    fewer = replace(observation, lifted=replace(observation.lifted, detections=tuple(others)))
    unpacked = unpack((pack(fewer), observation.frame.pose), SETTINGS).lifted
    assert [d.mask for d in unpacked.detections] == [d.mask for d in others]
    assert first.mask not in {d.mask for d in others}
    assert np.count_nonzero(unpacked.member_mask == first.mask) == first.n_cells


def test_a_frame_without_detections_comes_back_without(room_frame: Frame) -> None:
    unpacked = unpack((pack(bare(room_frame)), room_frame.pose), SETTINGS)
    assert unpacked.lifted.detections == ()
    assert len(unpacked.lifted.member_cell) == 0


def test_depth_at_the_edges_of_its_range_stays_in_it() -> None:
    depth = np.zeros((CAMERA.height, CAMERA.width), np.float32)
    depth[::3], depth[1::3] = 4.9999, 0.10001
    frame = Frame(0, 0.0, np.zeros((*depth.shape, 3), np.uint8), depth, CAMERA, np.eye(4))
    observation = bare(frame)
    unpacked = unpack((pack(observation), np.eye(4)), SETTINGS)
    assert (unpacked.surface.rows == observation.surface.rows).all()
    np.testing.assert_allclose(unpacked.frame.depth, observation.surface.depth, rtol=0.0013)


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
        "import os\nfrom razer.reintegration.frame_store import FrameStore\n"
        "store = FrameStore(0)\nstore.append(b'x' * 100_000)\nassert store.spilled_bytes == 100_000\n" + ending
    )
    environment = {"TMPDIR": str(tmp_path), "PATH": "", "PYTHONPATH": ":".join(sys.path)}
    subprocess.run([sys.executable, "-c", source], env=environment, capture_output=True, check=False)
    assert list(tmp_path.iterdir()) == []


def test_where_colour_was_not_seen_comes_back(room_frame: Frame) -> None:
    has_color = np.random.default_rng(0).random(room_frame.depth.shape) < 0.7
    back = unpack((pack(bare(replace(room_frame, has_color=has_color))), room_frame.pose), SETTINGS).frame
    assert back.has_color is not None
    np.testing.assert_array_equal(back.has_color, has_color[::2, ::2])
    assert unpack((pack(bare(room_frame)), room_frame.pose), SETTINGS).frame.has_color is None


def test_masks_say_nothing_of_what_colour_does_not_see(room_frame: Frame) -> None:
    left = np.zeros(room_frame.depth.shape, bool)
    left[:, :320] = True
    surface = observed(replace(room_frame, has_color=left))
    pixels = np.concatenate([surface.surface.columns[d.pixels] for d in surface.lifted.detections])
    assert len(pixels) > 100
    assert (pixels * surface.surface.stride < 320).all()
