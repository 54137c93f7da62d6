"""Every layout is recognised and read; every fault is named."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

from data_tools.readers.tum import CAMERAS, associate
from data_tools.recordings.trajectories import PROJECTED
from data_tools.registry import open_sequence, recognise
from razer.errors import BadInput, UnusableFrame
from razer.frame import Frame, Intrinsics
from razer.plugins import FULL_TRUST
from tests.support.recordings import (
    HEIGHT,
    WIDTH,
    camera_json,
    colour,
    depth,
    write_folder,
    write_image,
    write_seven_scenes,
    write_tum,
)

TRUTH = "".join(f"{stamp} {stamp} 0 0 0 0 0 1\n" for stamp in (0.95, 1.0, 1.05, 1.10, 1.15))


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


def test_stamps_are_associated_nearest_first_each_used_once() -> None:
    a = np.array([1.00, 1.03, 1.06, 2.0])
    b = np.array([1.061, 1.014, 1.029, 2.0201])
    # 1.03 takes 1.029 (1 ms) although 1.00 has no other partner but 1.014; 2.0 is 20.1 ms away.
    assert associate(a, b, 0.02) == [(0, 1), (1, 2), (2, 0)]


@pytest.mark.parametrize("seed", range(20))
def test_association_equals_the_slow_greedy_rule(seed: int) -> None:
    rng = np.random.default_rng(seed)
    a, b = rng.uniform(0, 0.5, 20), rng.uniform(0, 0.5, 25)
    gaps = np.abs(a[:, None] - b[None])
    expected = []
    while (best := gaps.min()) <= 0.02:
        i, j = np.argwhere(gaps == best)[0]
        expected.append((i, j))
        gaps[i, :] = gaps[:, j] = np.inf
    assert associate(a, b, 0.02) == sorted(expected, key=lambda pair: a[pair[0]])


def test_tum_frames_pair_colour_with_depth_and_interpolate_poses(tmp_path: Path) -> None:
    write_tum(tmp_path, [1.00, 1.04, 1.08, 1.20], [1.01, 1.045, 1.09, 1.30], TRUTH)
    sequence = open_sequence(tmp_path)
    assert (len(sequence), sequence.depth_scale) == (3, 5000)  # 1.20 and 1.30 find nobody
    assert sequence.intrinsics == CAMERAS["3"].at((WIDTH, HEIGHT))  # "freiburg3" in a comment
    for i, stamp in enumerate((1.01, 1.045, 1.09)):
        frame = sequence[i]
        assert frame.stamp == stamp
        assert frame.rgb[0, 0, 0] == i
        assert frame.depth[0, 0] == np.float32((5000 + i) / 5000)
        np.testing.assert_allclose(frame.pose[:3, 3], [stamp, 0, 0], atol=1e-9)


def test_a_tum_frame_outside_the_ground_truth_has_no_usable_pose(tmp_path: Path) -> None:
    write_tum(tmp_path, [0.5, 1.0], [0.5, 1.0], TRUTH)
    sequence = open_sequence(tmp_path)
    with pytest.raises(UnusableFrame, match=r"groundtruth\.txt does not cover 0\.5"):
        sequence[0]
    assert sequence[1].pose[0, 3] == 1.0


def test_the_tum_camera_is_unknown_without_a_hint(tmp_path: Path) -> None:
    write_tum(tmp_path, [1.0], [1.0])
    for name in ("rgb.txt", "depth.txt"):
        path = tmp_path / name
        path.write_text(path.read_text().replace("freiburg3", "attic"))
    with pytest.raises(BadInput, match="--intrinsics"):
        open_sequence(tmp_path)
    sequence = open_sequence(tmp_path, camera="9,9,3.5,2.5")
    assert (sequence.intrinsics.fx, sequence.has_poses) == (9, False)


def test_own_folder_with_everything(tmp_path: Path) -> None:
    write_folder(tmp_path, camera=camera_json(depth_scale=500.0))
    (tmp_path / "stamps.txt").write_text("10\n10.5\n11\n")
    (tmp_path / "trajectory.txt").write_text("10.0004 1 0 0 0 0 0 1\n11 3 0 0 0 0 0 1\n")
    ids = np.zeros((HEIGHT, WIDTH), np.uint16)
    ids[2, 3] = 40000
    for i in range(3):
        write_image(tmp_path / "ids" / f"{i:06d}.png", ids)
    (tmp_path / "truth").mkdir()
    (tmp_path / "truth" / "objects.json").write_text(json.dumps([{"id": 40000, "class": "cup", "size": 1}]))
    sequence = open_sequence(tmp_path)
    frame = sequence[0]
    assert (frame.stamp, frame.pose[0, 3], frame.depth[0, 0]) == (10, 1, 4)
    assert frame.instance_ids is not None
    assert frame.instance_ids.dtype == np.int32
    np.testing.assert_array_equal(np.argwhere(frame.instance_ids), [[2, 3]])
    assert (frame.instance_ids[2, 3], frame.instance_classes) == (40000, {40000: "cup"})
    with pytest.raises(UnusableFrame, match=r"trajectory\.txt has no pose at 10\.5"):
        sequence[1]
    assert sequence[2].pose[0, 3] == 3


def test_a_plain_folder_needs_only_intrinsics(tmp_path: Path) -> None:
    write_folder(tmp_path)
    with pytest.raises(BadInput, match="--intrinsics"):
        open_sequence(tmp_path)
    sequence = open_sequence(tmp_path, camera="10,11,3.5,2.5", depth_scale=2000)
    assert (sequence.has_poses, sequence.depth_scale, sequence.intrinsics.fy) == (False, 2000, 11)
    assert sequence[1].depth[0, 0] == np.float32(2001 / 2000)


def test_a_frame_lost_from_a_folder_does_not_shift_the_others(tmp_path: Path) -> None:
    write_folder(tmp_path, camera=camera_json())
    (tmp_path / "trajectory.txt").write_text("".join(f"{i / 30} {i} 0 0 0 0 0 1\n" for i in range(3)))
    (tmp_path / "color" / "000000.png").unlink()
    sequence = open_sequence(tmp_path)
    with pytest.raises(UnusableFrame, match=r"color/000000.* is missing"):
        sequence[0]
    (tmp_path / "depth" / "000000.png").unlink()
    frame = open_sequence(tmp_path)[0]
    assert (frame.rgb[0, 0, 0], frame.pose[0, 3]) == (1, 1)


def test_a_folder_with_matrices_and_other_names(tmp_path: Path) -> None:
    for i in (9, 10):
        write_image(tmp_path / "rgb" / f"color_{i}.png", colour(i))
        write_image(tmp_path / "depth" / f"depth_{i:04d}.png", depth(100 * i))
        (tmp_path / "pose").mkdir(exist_ok=True)
        pose = np.eye(4)
        pose[1, 3] = i
        np.savetxt(tmp_path / "pose" / f"{i}.txt", pose)
    sequence = open_sequence(tmp_path, camera="10,10,3.5,2.5")
    found = [
        (frame.rgb[0, 0, 0], float(frame.depth[0, 0]), frame.pose[1, 3]) for frame in map(sequence.__getitem__, (0, 1))
    ]
    assert found == [(9, np.float32(0.9), 9), (10, np.float32(1.0), 10)]


def test_layouts_are_recognised_and_reader_overrides(tmp_path: Path) -> None:
    scenes = write_seven_scenes(tmp_path / "a")
    tum = write_tum(tmp_path / "b", [1.0], [1.0])
    own = write_folder(tmp_path / "c", camera=camera_json())
    assert [recognise(folder) for folder in (scenes, tum, own)] == ["7scenes", "tum", "folder"]
    assert open_sequence(tum, reader="folder", camera="10,10,3.5,2.5").depth_scale == 1000
    assert open_sequence(own, reader="data_tools.readers.folder:read_folder", trust=FULL_TRUST).name == "c"


def _missing(folder: Path) -> dict:
    return {"folder": folder / "nowhere"}


def _empty(folder: Path) -> dict:
    return {"folder": folder}


def _unknown(folder: Path) -> dict:
    write_seven_scenes(folder / "seq-01")
    return {"folder": folder}


def _no_intrinsics(folder: Path) -> dict:
    return {"folder": write_seven_scenes(folder, intrinsics=False)}


def _all_broken(folder: Path) -> dict:
    write_seven_scenes(folder, frames=2)
    for path in folder.glob("*.depth.png"):
        truncate(path)
    return {"folder": folder}


def _wrong_list(folder: Path) -> dict:
    write_tum(folder, [1.0], [1.0])
    (folder / "depth.txt").write_text("one depth/0.png\n")
    return {"folder": folder}


def _broken_json(folder: Path) -> dict:
    write_folder(folder, camera=camera_json())
    (folder / "intrinsics.json").write_text('{"width": 8}')
    return {"folder": folder}


FOLDER_FAULTS = {
    "missing folder": (_missing, "nowhere does not exist"),
    "empty folder": (_empty, "is empty"),
    "one level too high": (_unknown, "no known layout.*seq-01"),
    "no intrinsics": (_no_intrinsics, "--intrinsics fx,fy,cx,cy"),
    "all frames broken": (_all_broken, r"no usable frame.*depth\.png is truncated"),
    "list without stamps": (_wrong_list, r"depth\.txt, line 1"),
    "broken intrinsics.json": (_broken_json, r"intrinsics\.json must be JSON"),
    "unknown reader": (lambda folder: {"folder": folder, "reader": "rosbag"}, "unknown reader 'rosbag'"),
    "wrong reader": (
        lambda folder: {"folder": write_seven_scenes(folder), "reader": "tum"},
        "has not the layout that reader 'tum' reads",
    ),
    "intrinsics of three": (lambda folder: {"folder": folder, "camera": "1,2,3"}, "'1,2,3' are not understood"),
    "negative focal length": (lambda folder: {"folder": folder, "camera": "-1,2,3,4"}, "must be positive"),
    "no such camera file": (lambda folder: {"folder": folder, "camera": "x.json"}, "does not exist"),
    "zero depth scale": (lambda folder: {"folder": folder, "depth_scale": 0.0}, "depth scale must be positive"),
}


@pytest.mark.parametrize("fault", FOLDER_FAULTS)
def test_an_unusable_folder_is_one_plain_line(tmp_path: Path, fault: str) -> None:
    prepare, message = FOLDER_FAULTS[fault]
    with pytest.raises(BadInput, match=message) as caught:
        open_sequence(**prepare(tmp_path))
    assert "\n" not in str(caught.value)


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
    assert frame.notes == (PROJECTED,)  # its rotations are off by up to 3e-4
    raw = np.loadtxt(real_data / "redkitchen" / "frame-000599.pose.txt")
    np.testing.assert_allclose(frame.pose, raw, atol=2e-4)


def test_tum(real_data: Path) -> None:
    sequence = open_sequence(real_data / "tum_fr1_rpy_head")
    assert (len(sequence), sequence.has_poses, sequence.depth_scale) == (60, True, 5000)
    assert sequence.intrinsics == Intrinsics(640, 480, 517.3, 516.5, 318.6, 255.3)
    frame = sequence[0]
    check_real_frame(frame)
    assert frame.stamp == 1305031229.528784
    truth = np.loadtxt(real_data / "tum_fr1_rpy_head" / "groundtruth.txt")
    after = np.searchsorted(truth[:, 0], frame.stamp)
    ends = truth[after - 1 : after + 1, 1:4]
    assert (frame.pose[:3, 3] >= ends.min(axis=0) - 1e-9).all()
    assert (frame.pose[:3, 3] <= ends.max(axis=0) + 1e-9).all()
