"""Replica in NICE-SLAM's layout, and its own ground truth on faces."""

from __future__ import annotations

import json
import pickle
from collections import Counter
from pathlib import Path

import cv2
import numpy as np
import pytest

from data_tools.registry import open_sequence, recognise
from data_tools.synthetic.synthetic_room import SyntheticRoom
from data_tools.truth.ground_truth import GroundTruth
from data_tools.truth.open_truth import has_truth, open_truth
from data_tools.truth.ply import read_ply
from data_tools.truth.replica_truth import majority_of_faces, read_replica_truth
from data_tools.writers.replica import write_replica
from razer.errors import BadInput, UnusableFrame
from razer.vocabulary import vocabulary
from tests.support.recordings import colour, depth, write_image

CAMERA = {"camera": {"w": 8, "h": 6, "fx": 10.0, "fy": 11.0, "cx": 3.5, "cy": 2.5, "scale": 6553.5}}


def write_scene(folder: Path, frames: int = 3, size: tuple[int, int] = (8, 6)) -> Path:
    poses = []
    for i in range(frames):
        write_image(folder / "results" / f"frame{i:06d}.jpg", colour(i, *size))
        write_image(folder / "results" / f"depth{i:06d}.png", depth(13107 + i, *size))
        pose = np.eye(4)
        pose[0, 3] = i
        poses.append(" ".join(f"{x:.18e}" for x in pose.ravel()))
    (folder / "traj.txt").write_text("\n".join(poses) + "\n")
    return folder


@pytest.mark.parametrize("place", ["beside all scenes", "in the scene"])
def test_the_camera_is_told_by_cam_params(tmp_path: Path, place: str) -> None:
    folder = write_scene(tmp_path / "room0")
    (tmp_path / ("cam_params.json" if place == "beside all scenes" else "room0/cam_params.json")).write_text(
        json.dumps(CAMERA)
    )
    assert recognise(folder) == "replica"
    sequence = pickle.loads(pickle.dumps(open_sequence(folder)))
    assert (len(sequence), sequence.has_poses, sequence.depth_scale) == (3, True, 6553.5)
    assert (sequence.intrinsics.fx, sequence.intrinsics.fy) == (10, 11)
    for i in (2, 0, 1):
        np.testing.assert_allclose(sequence[i].depth, (13107 + i) / 6553.5, rtol=1e-6)
        assert (sequence[i].pose[0, 3], sequence[i].stamp) == (i, pytest.approx(i / 30))


def test_without_cam_params_the_camera_is_that_of_the_published_renderings(tmp_path: Path) -> None:
    sequence = open_sequence(write_scene(tmp_path / "room0", 1, (1200, 680)))
    told = sequence.intrinsics
    assert (told.fx, told.fy, told.cx, told.cy, sequence.depth_scale) == (600, 600, 599.5, 339.5, 6553.5)
    with pytest.raises(BadInput, match=r"1200x680 .* 8x6"):
        open_sequence(write_scene(tmp_path / "room1"))


@pytest.mark.parametrize(
    ("text", "problem"),
    [
        ("{}", 'must be JSON with "camera"'),
        ('{"camera": {"w": 8}}', 'must be JSON with "camera"'),
        ("camera:", "cannot be read: line 1, column 1 is not JSON"),
        ('{"camera": 3}', 'must be JSON with "camera"'),
    ],
)
def test_damaged_cam_params_are_one_line(tmp_path: Path, text: str, problem: str) -> None:
    folder = write_scene(tmp_path / "room0")
    (folder / "cam_params.json").write_text(text)
    with pytest.raises(BadInput, match=rf"cam_params\.json {problem}") as caught:
        open_sequence(folder)
    assert "\n" not in str(caught.value)


def test_lines_without_a_pose_cost_their_frames_alone(tmp_path: Path) -> None:
    folder = write_scene(tmp_path / "room0", 6)
    (folder / "cam_params.json").write_text(json.dumps(CAMERA))
    lines = (folder / "traj.txt").read_text().splitlines()
    lines[1], lines[2], lines[3] = " ".join(["nan"] * 16), "1 2 3", lines[3].replace("3.0", "three ", 1)
    (folder / "traj.txt").write_text("\n".join(lines[:5]))
    sequence = open_sequence(folder)
    reasons = {1: "line 2: .*not finite", 2: "line 3: a pose has 16 numbers, not 3", 5: "there are only 5 poses"}
    for i, reason in (reasons | {3: r"line 4"}).items():
        with pytest.raises(UnusableFrame, match=rf"traj\.txt, {reason}" if i < 5 else reason):
            sequence[i]
    assert [sequence[i].pose[0, 3] for i in (0, 4)] == [0, 4]


def test_what_is_written_is_named_and_scaled_as_nice_slam_does(tmp_path: Path) -> None:
    room = SyntheticRoom(0, 2, 64, 48)
    write_replica(room, tmp_path / "room0")
    folder = tmp_path / "room0"
    names = {path.name for path in (folder / "results").iterdir()}
    assert names == {
        f"{kind}00000{i}.{suffix}" for kind, suffix in (("frame", "jpg"), ("depth", "png")) for i in (0, 1)
    }
    np.testing.assert_allclose(np.loadtxt(folder / "traj.txt")[1].reshape(4, 4), room[1].pose, atol=1e-12)
    raw = cv2.imread(str(folder / "results" / "depth000001.png"), cv2.IMREAD_UNCHANGED)
    np.testing.assert_array_equal(raw, np.rint(room[1].depth.astype(float) * 6553.5))
    told = json.loads((folder / "cam_params.json").read_text())["camera"]
    assert (told["w"], told["h"], told["scale"], told["fx"]) == (64, 48, 6553.5, room.intrinsics.fx)


def test_the_truth_goes_round(tmp_path: Path) -> None:
    room = SyntheticRoom(0, 2, 64, 48)
    truth = room.truth(0.1)
    write_replica(room, tmp_path / "room0", truth=truth)
    info = json.loads((tmp_path / "room0" / "habitat" / "info_semantic.json").read_text())
    numbers = {each["name"]: each["id"] for each in info["classes"]}
    assert (numbers["chair"], numbers["floor"], numbers["wall"], numbers["rug"]) == (20, 40, 93, 98)
    assert [info["id_to_label"][each["id"]] for each in info["objects"]] == [
        each["class_id"] for each in info["objects"]
    ]
    back = open_truth(tmp_path / "room0")
    for name in ("vertices", "triangles", "instances"):
        np.testing.assert_array_equal(getattr(back, name), getattr(truth, name))
    assert back.instance_classes == truth.instance_classes
    assert back.visible.all()
    by_list = {name: open_truth(tmp_path / "room0", vocabulary=name) for name in ("replica", "scannet200", "nyu40")}
    couch = next(i for i, name in truth.instance_classes.items() if name == "couch")
    assert [each.instance_classes[couch] for each in by_list.values()] == ["sofa", "couch", "sofa"]
    assert by_list["scannet200"].instance_classes == truth.instance_classes


def test_a_face_between_objects_is_of_the_one_with_most_corners(tmp_path: Path) -> None:
    instances = np.array([1, 2, 2, 3], np.int32)
    triangles = np.array([[0, 1, 2], [1, 0, 2], [1, 2, 0], [0, 1, 3], [3, 3, 0]], np.int32)
    points, seen = np.zeros((4, 3), np.float32), np.ones(4, np.bool_)
    truth = GroundTruth(points, triangles, instances, instances, {1: "bed", 2: "desk", 3: "wall"}, seen)
    write_replica(SyntheticRoom(0, 1, 64, 48), tmp_path / "a", truth=truth)
    mesh = read_ply(tmp_path / "a" / "habitat" / "mesh_semantic.ply")
    assert mesh.of_face["object_id"].tolist() == [2, 2, 2, 1, 3]


def faces_truth(folder: Path, objects: list[dict], faces: list[tuple[list[int], int]]) -> GroundTruth:
    lines = ["ply", "format ascii 1.0", "element vertex 7", *(f"property float {axis}" for axis in "xyz")]
    lines += [f"element face {len(faces)}", "property list uchar int vertex_indices", "property int object_id"]
    lines += ["end_header", *(f"{i} 0 0" for i in range(7))]
    lines += [" ".join(map(str, (len(corners), *corners, number))) for corners, number in faces]
    folder.mkdir(parents=True)
    (folder / "mesh_semantic.ply").write_text("\n".join(lines) + "\n")
    (folder / "info_semantic.json").write_text(json.dumps({"objects": objects}))
    return open_truth(folder.parent)


def test_objects_of_quads_go_to_their_corners_by_majority(tmp_path: Path) -> None:
    objects = [
        {"id": 0, "class_id": 20, "class_name": "chair"},
        {"id": 3, "class_id": 76, "class_name": "sofa"},
        {"id": 5, "class_id": -1, "class_name": "undefined"},
    ]
    # Vertex 1: twice object 3, once 0. Vertex 2: object 3 and 5 once each. Vertex 4: an object that is not listed.
    faces = [([0, 1, 2, 3], 3), ([1, 0, 3], 3), ([1, 5, 5], 0), ([2, 5, 5], 5), ([4, 4, 4], 9)]
    truth = faces_truth(tmp_path / "room_0" / "habitat", objects, faces)
    assert truth.instances.tolist() == [3, 3, 3, 3, 0, 6, 0]
    assert truth.classes.tolist() == [76, 76, 76, 76, 0, 20, 0]
    assert truth.class_names == {20: "chair", 76: "sofa"}
    # The scene among others, under NICE-SLAM's name for it.
    assert open_truth(tmp_path, scene="room0").instances.tolist() == truth.instances.tolist()


def test_majority_agrees_with_counting_face_by_face(tmp_path: Path) -> None:
    rng = np.random.default_rng(0)
    faces = [(rng.choice(7, rng.integers(3, 6), replace=False).tolist(), int(rng.integers(-1, 4))) for _ in range(60)]
    faces_truth(tmp_path / "a" / "habitat", [], faces)
    mesh = read_ply(tmp_path / "a" / "habitat" / "mesh_semantic.ply")
    votes = [Counter(number for corners, number in faces if vertex in corners) for vertex in range(7)]
    slow = [min(-count * 100 + number for number, count in each.items()) for each in votes]
    slow = [(value + 50) % 100 - 50 for value in slow]
    assert majority_of_faces(mesh, mesh.of_face["object_id"].astype(np.int64), 7).tolist() == slow


@pytest.mark.parametrize(
    ("name", "text", "message"),
    [
        ("info_semantic.json", '{"objects": [{"id": 1}]}', r'info_semantic\.json must be JSON with "objects"'),
        ("info_semantic.json", "[", r"info_semantic\.json must be JSON"),
        ("mesh_semantic.ply", "plainly not", r"mesh_semantic\.ply is no PLY file"),
        ("mesh_semantic.ply", None, r"mesh_semantic\.ply cannot be read: No such file"),
    ],
)
def test_damaged_truth_is_one_line(tmp_path: Path, name: str, text: str | None, message: str) -> None:
    faces_truth(tmp_path / "a" / "habitat", [], [([0, 1, 2], 1)])
    path = tmp_path / "a" / "habitat" / name
    path.unlink() if text is None else path.write_text(text)
    assert has_truth(tmp_path / "a")
    with pytest.raises(BadInput, match=message) as caught:
        open_truth(tmp_path / "a")
    assert "\n" not in str(caught.value)
    with pytest.raises(BadInput, match=r"info_semantic\.json is missing"):
        read_replica_truth(tmp_path)


def test_the_vocabulary_has_the_numbers_of_the_dataset() -> None:
    replica = vocabulary("replica")
    # Pairs that papers on Replica print.
    known = {
        3: "basket",
        7: "bed",
        20: "chair",
        44: "indoor-plant",
        59: "picture",
        76: "sofa",
        80: "table",
        97: "window",
    }
    assert len(replica.categories) == 101
    assert {number: replica.by_id[number].name for number in known} == known
    assert {category.name for category in replica.categories if category.stuff} == {"wall", "floor", "ceiling"}
