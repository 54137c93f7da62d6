"""Redwood and Open3D folders: images, a .log of poses, and a column-major camera."""

from __future__ import annotations

import json
import pickle
from pathlib import Path

import numpy as np
import open3d as o3d
import pytest
from scipy.spatial.transform import Rotation

from data_tools.registry import open_sequence, recognise
from razer.errors import BadInput, UnusableFrame
from razer.frame import Intrinsics
from tests.support.recordings import HEIGHT, WIDTH, camera_json, colour, depth, write_folder, write_image

# As Open3D writes it: the matrix column by column.
OPEN3D_CAMERA = {"width": WIDTH, "height": HEIGHT, "intrinsic_matrix": [10.0, 0, 0, 0, 12.0, 0, 3.5, 2.25, 1]}


def log(numbers: list[int]) -> str:
    return "".join(f"{n} {n} {n + 1}\n1 0 0 {n + 0.5}\n0 1 0 0\n0 0 1 0\n0 0 0 1\n" for n in numbers)


def write_redwood(
    folder: Path,
    names: list[tuple[str, str]],
    poses: list[int],
    place: str = "trajectory.log",
    camera: dict | None = OPEN3D_CAMERA,
    color_folder: str = "color",
) -> Path:
    for i, (color, deep) in enumerate(names):
        write_image(folder / color_folder / color, colour(i))
        write_image(folder / "depth" / deep, depth(1000 + i))
    (folder / place).parent.mkdir(parents=True, exist_ok=True)
    (folder / place).write_text(log(poses))
    if camera:
        (folder / "camera_primesense.json").write_text(json.dumps(camera))
    return folder


def plain(numbers: range) -> list[tuple[str, str]]:
    return [(f"{n:06d}.png", f"{n:06d}.png") for n in numbers]


SHAPES = {
    "open3d reconstruction system": (plain(range(3)), {"place": "scene/trajectory.log"}),
    "zhou and koltun, counted from 1": (plain(range(1, 4)), {"place": "../lounge_trajectory.log"}),
    "redwood scan": (
        [(f"{n:07d}-{33366 * n:012d}.png", f"{n:07d}-{33366 * n:012d}.png") for n in range(1, 4)],
        {"place": "trajectory.log", "color_folder": "rgb"},
    ),
    "augmented icl-nuim": (plain(range(3)), {"place": "office1-traj.txt", "color_folder": "colors"}),
    "stamps differ between colour and depth": (
        [(f"{n:07d}-{33366 * n:012d}.png", f"{n:07d}-{33366 * n + 900:012d}.png") for n in range(1, 4)],
        {"color_folder": "image"},
    ),
}


@pytest.mark.parametrize("shape", SHAPES)
def test_images_and_poses_pair_in_order(tmp_path: Path, shape: str) -> None:
    names, options = SHAPES[shape]
    folder = write_redwood(tmp_path / "lounge_png", names, [0, 1, 2], **options)
    assert recognise(folder) == "redwood"
    sequence = pickle.loads(pickle.dumps(open_sequence(folder)))
    assert (len(sequence), sequence.has_poses, sequence.depth_scale) == (3, True, 1000)
    assert sequence.intrinsics == Intrinsics(WIDTH, HEIGHT, 10, 12, 3.5, 2.25)
    for i in range(3):
        frame = sequence[i]
        assert (frame.rgb[0, 0, 0], frame.pose[0, 3]) == (i, i + 0.5)
        assert frame.depth[0, 0] == np.float32((1000 + i) / 1000)
        assert frame.stamp == pytest.approx(i / 30)


@pytest.mark.parametrize("first", [0, 1])
def test_every_tenth_image_of_a_full_log_keeps_its_own_pose(tmp_path: Path, first: int) -> None:
    names = plain(range(first, 31, 10))
    sequence = open_sequence(write_redwood(tmp_path, names, list(range(31))))
    assert [sequence[i].pose[0, 3] for i in range(len(names))] == [10 * i + 0.5 for i in range(len(names))]


def test_a_log_shorter_than_the_images_leaves_the_rest_without_pose(tmp_path: Path) -> None:
    sequence = open_sequence(write_redwood(tmp_path, plain(range(4)), [0, 1]))
    assert sequence[1].pose[0, 3] == 1.5
    with pytest.raises(UnusableFrame, match="no pose 2"):
        sequence[2]


def test_the_default_camera_is_primesense(tmp_path: Path) -> None:
    folder = write_redwood(tmp_path, [], [0], camera=None, color_folder="rgb")
    for part, image in (("rgb", colour(0, 640, 480)), ("depth", depth(1000, 640, 480))):
        write_image(folder / part / "00000.png", image)
    assert open_sequence(folder).intrinsics == Intrinsics(640, 480, 525, 525, 319.5, 239.5)
    assert open_sequence(folder, camera="500,500,320,240").intrinsics.fx == 500


def test_a_log_and_a_camera_that_open3d_wrote(tmp_path: Path) -> None:
    folder = write_redwood(tmp_path, plain(range(3)), [0, 1, 2], camera=None)
    intrinsic = o3d.camera.PinholeCameraIntrinsic(WIDTH, HEIGHT, 10.0, 12.0, 3.5, 2.25)
    poses, parameters = [], []
    for i in range(3):
        pose = np.eye(4)
        pose[:3, :3], pose[:3, 3] = Rotation.from_euler("xyz", [0.1, 0.2 * i, 0.3]).as_matrix(), (i, 2, 3)
        poses.append(pose)
        parameters.append(o3d.camera.PinholeCameraParameters())
        parameters[-1].intrinsic, parameters[-1].extrinsic = intrinsic, np.linalg.inv(pose)
    trajectory = o3d.camera.PinholeCameraTrajectory()
    trajectory.parameters = parameters
    o3d.io.write_pinhole_camera_trajectory(str(folder / "trajectory.log"), trajectory)
    o3d.io.write_pinhole_camera_intrinsic(str(folder / "camera.json"), intrinsic)
    sequence = open_sequence(folder)
    assert sequence.intrinsics == Intrinsics(WIDTH, HEIGHT, 10, 12, 3.5, 2.25)
    for i in range(3):
        np.testing.assert_allclose(sequence[i].pose, poses[i], atol=1e-6)


def test_a_camera_of_our_own_layout_counts_before_the_default(tmp_path: Path) -> None:
    folder = write_redwood(tmp_path, plain(range(2)), [0, 1], camera=None)
    (folder / "intrinsics.json").write_text(json.dumps(camera_json(depth_scale=500.0)))
    sequence = open_sequence(folder)
    assert (recognise(folder), sequence.intrinsics.fx, sequence.depth_scale) == ("redwood", 10, 500)


def test_a_camera_file_that_is_wrong_is_one_line(tmp_path: Path) -> None:
    wrong = OPEN3D_CAMERA | {"intrinsic_matrix": [1, 2, 3]}
    with pytest.raises(BadInput, match=r"camera_primesense\.json must hold") as caught:
        open_sequence(write_redwood(tmp_path, plain(range(2)), [0, 1], camera=wrong))
    assert "\n" not in str(caught.value)


def test_a_folder_without_a_log_and_one_with_a_log_of_a_program_stay_plain(tmp_path: Path) -> None:
    folder = write_folder(tmp_path, camera=camera_json())
    assert recognise(folder) == "folder"
    (folder / "convert.log").write_text("started\ndone\n")
    assert recognise(folder) == "folder"
