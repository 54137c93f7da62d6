"""SceneNN as its playback tool and its download leave it: image00001.png, pose 0 of trajectory.log for it."""

from __future__ import annotations

import pickle
from pathlib import Path

import numpy as np
import pytest

from data_tools.recordings.pose_log import read_pose_log
from data_tools.registry import open_sequence, recognise
from razer.errors import BadInput, UnusableFrame
from razer.frame import Intrinsics
from tests.support.recordings import CAMERA_MATRIX, HEIGHT, WIDTH, colour, depth, write_image


def log_entry(number: int, x: float, rows: str | None = None) -> str:
    return f"{number} {number} {number + 1}\n" + (rows or f"1 0 0 {x}\n0 1 0 0\n0 0 1 0\n0 0 0 1\n")


def write_scenenn(folder: Path, frames: int = 4, log: str | None = None, intrinsic: bool = True) -> Path:
    """Frames are numbered from 1; image k is red = k and pose k - 1 of the log stands at x = k."""
    for k in range(1, frames + 1):
        write_image(folder / "image" / f"image{k:05d}.png", colour(k))
        write_image(folder / "depth" / f"depth{k:05d}.png", depth(1000 + k))
    entries = log if log is not None else "".join(log_entry(k, k + 1) for k in range(frames))
    (folder / "trajectory.log").write_text(entries)
    if intrinsic:
        (folder / "intrinsic.txt").write_text(CAMERA_MATRIX)
    return folder


def test_image_k_has_pose_k_minus_1(tmp_path: Path) -> None:
    assert recognise(write_scenenn(tmp_path)) == "scenenn"
    sequence = open_sequence(tmp_path)
    assert (len(sequence), sequence.has_poses, sequence.depth_scale) == (4, True, 1000)
    assert sequence.intrinsics == Intrinsics(WIDTH, HEIGHT, 10, 10, 3.5, 2.5)
    for index in (3, 0, 2):
        frame = sequence[index]
        assert (frame.rgb[0, 0, 0], frame.pose[0, 3]) == (index + 1, index + 1)
        assert frame.depth[0, 0] == np.float32((1001 + index) / 1000)
        assert frame.stamp == pytest.approx(index / 30)


def test_the_datasets_camera_stands_where_the_folder_names_none(tmp_path: Path) -> None:
    write_scenenn(tmp_path, frames=0, intrinsic=False)
    write_image(tmp_path / "image" / "image00001.png", colour(1, 640, 480))
    write_image(tmp_path / "depth" / "depth00001.png", depth(1000, 640, 480))
    (tmp_path / "trajectory.log").write_text(log_entry(0, 1))
    assert open_sequence(tmp_path).intrinsics == Intrinsics(640, 480, 544.47329, 544.47329, 320, 240)


def test_the_camera_is_not_stretched_over_images_of_another_shape(tmp_path: Path) -> None:
    write_scenenn(tmp_path, intrinsic=False)
    write_image(tmp_path / "image" / "image00001.png", colour(1, 10, 6))
    for k in range(1, 5):
        write_image(tmp_path / "image" / f"image{k:05d}.png", colour(k, 10, 6))
        write_image(tmp_path / "depth" / f"depth{k:05d}.png", depth(1000, 10, 6))
    with pytest.raises(BadInput, match="640x480"):
        open_sequence(tmp_path)


def test_a_lost_image_does_not_shift_poses_or_images(tmp_path: Path) -> None:
    write_scenenn(tmp_path)
    (tmp_path / "image" / "image00002.png").unlink()
    (tmp_path / "depth" / "depth00003.png").unlink()
    sequence = open_sequence(tmp_path)
    assert len(sequence) == 4
    for index, name in ((1, "image/image00002.png"), (2, "depth/depth00003.png")):
        with pytest.raises(UnusableFrame, match=f"{name} is missing"):
            sequence[index]
    assert (sequence[3].rgb[0, 0, 0], sequence[3].pose[0, 3]) == (4, 4)


BAD_POSES = {
    "zero rotation": ("0 0 0 0\n" * 3 + "0 0 0 1\n", "rotation is zero"),
    "all zero": ("0 0 0 0\n" * 4, "rotation is zero"),
    "nan": ("nan nan nan nan\n" * 3 + "0 0 0 1\n", "not finite"),
    "minus infinity": ("1 0 0 -inf\n0 1 0 0\n0 0 1 0\n0 0 0 1\n", "not finite"),
    "no number": ("1 0 0 -1.#IND\n0 1 0 0\n0 0 1 0\n0 0 0 1\n", "not finite"),
    "mirrored": ("1 0 0 0\n0 1 0 0\n0 0 -1 0\n0 0 0 1\n", "left-handed"),
    "short row": ("1 0 0\n0 1 0 0\n0 0 1 0\n0 0 0 1\n", "not finite"),
}


@pytest.mark.parametrize("fault", BAD_POSES)
def test_a_bad_pose_costs_its_frame_alone(tmp_path: Path, fault: str) -> None:
    rows, reason = BAD_POSES[fault]
    write_scenenn(tmp_path, log=log_entry(0, 1) + log_entry(1, 2, rows) + log_entry(2, 3) + log_entry(3, 4))
    sequence = open_sequence(tmp_path)
    with pytest.raises(UnusableFrame, match=rf"trajectory\.log, pose 1: .*{reason}") as caught:
        sequence[1]
    assert "\n" not in str(caught.value)
    assert [sequence[i].pose[0, 3] for i in (0, 2, 3)] == [1, 3, 4]


@pytest.mark.parametrize("cut", [2, 5, 12, 30])
def test_a_log_that_is_cut_off_keeps_its_whole_poses(tmp_path: Path, cut: int) -> None:
    whole = "".join(log_entry(k, k + 1) for k in range(4))
    write_scenenn(tmp_path, log=whole[: -len(log_entry(3, 4)) - cut])
    sequence = open_sequence(tmp_path)
    assert [sequence[i].pose[0, 3] for i in (0, 1)] == [1, 2]
    for index in (2, 3):
        with pytest.raises(UnusableFrame, match=f"no pose {index}|pose {index}: .*not finite"):
            sequence[index]


def test_numbers_of_a_log_decide_and_order_only_where_they_repeat(tmp_path: Path) -> None:
    write_scenenn(tmp_path, log=log_entry(0, 1) + log_entry(3, 4))
    sequence = open_sequence(tmp_path)
    assert sequence[3].pose[0, 3] == 4
    with pytest.raises(UnusableFrame, match="no pose 1"):
        sequence[1]
    path = tmp_path / "trajectory.log"
    path.write_text("".join(log_entry(0, x) for x in (5, 6, 7)))
    assert {k: pose[0, 3] for k, pose in read_pose_log(path).items()} == {0: 5, 1: 6, 2: 7}


def test_a_log_that_counts_like_the_images_is_not_shifted(tmp_path: Path) -> None:
    sequence = open_sequence(write_scenenn(tmp_path, log="".join(log_entry(k, k) for k in range(1, 5))))
    assert [sequence[i].pose[0, 3] for i in range(4)] == [1, 2, 3, 4]
    (tmp_path / "trajectory.log").write_text("".join(log_entry(k, k + 1) for k in range(1, 4)))  # 0 is lost
    assert [open_sequence(tmp_path)[i].pose[0, 3] for i in (1, 2, 3)] == [2, 3, 4]


@pytest.mark.parametrize(("log", "message"), [("", "holds no pose"), ("a 0 1\n" + "0 0 0 0\n" * 4, "line 1")])
def test_a_log_that_is_none_is_one_line(tmp_path: Path, log: str, message: str) -> None:
    with pytest.raises(BadInput, match=message) as caught:
        open_sequence(write_scenenn(tmp_path, log=log))
    assert "\n" not in str(caught.value)
    assert not open_sequence(tmp_path, use_poses=False).has_poses


def test_stamps_are_those_of_depth(tmp_path: Path) -> None:
    write_scenenn(tmp_path)
    (tmp_path / "timestamp.txt").write_text("1 33000 40000\n2 66000 73000\n3 99000 106000\n4 132000 139000\n")
    assert [open_sequence(tmp_path)[i].stamp for i in range(4)] == [0.04, 0.073, 0.106, 0.139]


def test_a_separate_log_is_found_and_the_sequence_travels(tmp_path: Path) -> None:
    write_scenenn(tmp_path)
    (tmp_path / "trajectory.log").rename(tmp_path / "005_trajectory.log")
    sequence = pickle.loads(pickle.dumps(open_sequence(tmp_path)))
    assert sequence[2].pose[0, 3] == 3
