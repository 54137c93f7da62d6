"""7-Scenes: frames as written, and faults of single frames."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from data_tools.registry import open_sequence
from razer.errors import UnusableFrame
from razer.frame import Frame, Intrinsics
from tests.support.recordings import HEIGHT, WIDTH, colour, depth, write_image, write_seven_scenes


def test_seven_scenes_frames_are_what_was_written(tmp_path: Path) -> None:
    sequence = open_sequence(write_seven_scenes(tmp_path))
    assert (len(sequence), sequence.has_poses, sequence.depth_scale) == (3, True, 1000)
    assert sequence.intrinsics == Intrinsics(WIDTH, HEIGHT, 10, 10, 3.5, 2.5)
    frame = sequence[2]
    np.testing.assert_array_equal(frame.rgb, colour(2))
    np.testing.assert_array_equal(frame.depth, np.float32(1.002))
    assert (frame.index, frame.stamp, frame.pose[0, 3]) == (2, 2 / 30, 2)
    assert (frame.instance_ids, frame.notes) == (None, ())
    with pytest.raises(IndexError):
        sequence[3]


def test_0_and_65535_are_no_depth(tmp_path: Path) -> None:
    write_seven_scenes(tmp_path)
    raw = depth(1500)
    raw[0, 0], raw[1, 1] = 0, 65535
    write_image(tmp_path / "frame-000001.depth.png", raw)
    expected = np.full((HEIGHT, WIDTH), 1.5, np.float32)
    expected[0, 0] = expected[1, 1] = 0
    np.testing.assert_array_equal(open_sequence(tmp_path)[1].depth, expected)


def test_a_recording_without_poses_has_none(tmp_path: Path) -> None:
    write_seven_scenes(tmp_path)
    assert open_sequence(tmp_path, use_poses=False)[0].world_from_camera is None
    for path in tmp_path.glob("*.pose.txt"):
        path.unlink()
    sequence = open_sequence(tmp_path)
    assert not sequence.has_poses
    assert sequence[0].world_from_camera is None


def truncate(path: Path) -> None:
    path.write_bytes(path.read_bytes()[:-20])


FRAME_FAULTS = {
    "truncated colour": (truncate, "color.png", "truncated"),
    "truncated depth": (truncate, "depth.png", "truncated"),
    "empty depth": (lambda path: path.write_bytes(b""), "depth.png", "empty"),
    "no image": (lambda path: path.write_text("IEND but no image"), "color.png", "no image"),
    "missing colour": (Path.unlink, "color.png", "missing"),
    "missing depth": (Path.unlink, "depth.png", "missing"),
    "missing pose": (Path.unlink, "pose.txt", "missing"),
    "wrong size": (lambda path: write_image(path, colour(width=4)), "color.png", "4x6 where others are 8x6"),
    "8-bit depth": (lambda path: write_image(path, depth().astype(np.uint8)), "depth.png", "16-bit"),
    "all depth invalid": (lambda path: write_image(path, depth(65535)), "depth.png", "no valid depth"),
    "minus infinity": (lambda path: path.write_text("-inf " * 16), "pose.txt", "not finite"),
    "zero rotation": (lambda path: path.write_text("0 " * 15 + "1"), "pose.txt", "rotation is zero"),
}


@pytest.mark.parametrize("fault", FRAME_FAULTS)
def test_a_broken_frame_is_named_and_costs_no_other(tmp_path: Path, fault: str) -> None:
    plant, suffix, reason = FRAME_FAULTS[fault]
    write_seven_scenes(tmp_path)
    plant(tmp_path / f"frame-000001.{suffix}")
    sequence = open_sequence(tmp_path)
    assert len(sequence) == 3
    with pytest.raises(UnusableFrame, match=rf"frame-000001\.{suffix}.*{reason}"):
        sequence[1]
    assert [sequence[i].index for i in (0, 2)] == [0, 2]


def test_a_truncated_jpeg_is_not_filled_with_grey(tmp_path: Path) -> None:
    write_seven_scenes(tmp_path)
    (tmp_path / "frame-000000.color.png").unlink()
    path = tmp_path / "frame-000000.color.jpg"
    write_image(path, colour(9))
    assert open_sequence(tmp_path)[0].rgb.shape == (HEIGHT, WIDTH, 3)
    truncate(path)
    with pytest.raises(UnusableFrame, match=r"color\.jpg is truncated"):
        open_sequence(tmp_path)[0]


def test_the_first_frames_size_does_not_decide(tmp_path: Path) -> None:
    write_seven_scenes(tmp_path, frames=4)
    write_image(tmp_path / "frame-000000.color.png", colour(width=4))
    sequence = open_sequence(tmp_path)
    assert sequence.intrinsics.width == WIDTH
    with pytest.raises(UnusableFrame, match="frame-000000"):
        sequence[0]


def check_real_frame(frame: Frame) -> None:
    valid = frame.depth[frame.depth > 0]
    assert valid.size > 100_000
    assert 0.3 < np.median(valid) < 4
    assert frame.rgb.std() > 20


def test_redkitchen(real_data: Path) -> None:
    sequence = open_sequence(real_data / "redkitchen")
    assert (len(sequence), sequence.has_poses, sequence.depth_scale) == (600, True, 1000)
    assert sequence.intrinsics == Intrinsics(640, 480, 585, 585, 320, 240)
    frame = sequence[599]
    check_real_frame(frame)
    assert frame.notes == ()  # its rotations are off by up to 3e-4, as its four decimals are
    raw = np.loadtxt(real_data / "redkitchen" / "frame-000599.pose.txt")
    np.testing.assert_allclose(frame.pose, raw, atol=2e-4)
