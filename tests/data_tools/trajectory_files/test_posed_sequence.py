"""Poses from files of other programs: each kind brings the same frames to the same places, and says what is wrong."""

from __future__ import annotations

import pickle
from dataclasses import replace

import numpy as np
import pytest

from data_tools.recordings.recorded_sequence import ImageSource
from data_tools.registry import open_sequence
from data_tools.synthetic.synthetic_room import SyntheticRoom
from data_tools.trajectory_files.posed_sequence import posed_by
from razer.errors import BadInput, UnusableFrame
from slam.se3 import exp_se3
from tests.support.pose_files import curved_path, write_colmap, write_kitti, write_transforms, write_tum_lines
from tests.support.recordings import camera_json, write_folder, write_seven_scenes

N = 6
PATH = curved_path(N)
NAMES = [f"{i:06d}.png" for i in range(N)]
WRITERS = {
    "TUM": lambda path: write_tum_lines(path, [i / 30 for i in range(N)], PATH),
    "KITTI": lambda path: write_kitti(path, PATH),
    "COLMAP": lambda path: write_colmap(path, NAMES, PATH),
    "transforms.json": lambda path: write_transforms(path, [f"./images/{name}" for name in NAMES], PATH),
}


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    return write_folder(tmp_path_factory.mktemp("recording"), N, camera_json())


def refused(folder, path):
    with pytest.raises(BadInput) as error:
        open_sequence(folder, poses_from=path)
    assert str(error.value).startswith(str(path))
    return str(error.value)


@pytest.mark.parametrize("kind", WRITERS)
def test_every_kind_brings_the_frames_to_the_same_places(kind, folder, tmp_path):
    sequence = open_sequence(folder, poses_from=WRITERS[kind](tmp_path / "poses"))
    assert sequence.has_poses
    assert kind in sequence.poses_note
    assert f"{N} of {N} frames have one" in sequence.poses_note
    assert ("taken as metres" in sequence.poses_note) == (kind in ("COLMAP", "transforms.json"))
    for frame, pose in zip(pickle.loads(pickle.dumps(sequence)), PATH, strict=True):
        np.testing.assert_allclose(frame.world_from_camera, pose, atol=1e-9)


def test_a_file_stands_for_the_poses_of_the_recording(tmp_path):
    folder = write_seven_scenes(tmp_path / "scenes", N)
    names = [f"frame-{i:06d}.color.png" for i in range(N)]
    sequence = open_sequence(folder, poses_from=write_colmap(tmp_path / "images.txt", names, PATH))
    np.testing.assert_allclose(sequence[3].pose, PATH[3], atol=1e-9)
    assert open_sequence(folder)[3].pose[0, 3] == 3


def test_frames_without_a_pose_are_skipped_and_counted(folder, tmp_path):
    few = [0, 2, 5]
    path = write_colmap(tmp_path / "images.txt", [NAMES[i] for i in few], [PATH[i] for i in few])
    sequence = open_sequence(folder, poses_from=path)
    assert f"3 of {N} frames have one" in sequence.poses_note
    np.testing.assert_allclose(sequence[5].pose, PATH[5], atol=1e-9)
    with pytest.raises(UnusableFrame, match=r"images\.txt has no pose"):
        sequence[1]


def test_stamps_of_the_frames_rate_are_matched_within_half_a_gap(folder, tmp_path):
    late = [i / 30 + 0.010 for i in range(N)]
    late[4] += 0.010  # 20 ms late, where half a gap is 17
    sequence = open_sequence(folder, poses_from=write_tum_lines(tmp_path / "t.txt", late, PATH))
    assert "nearest stamps" in sequence.poses_note
    np.testing.assert_allclose(sequence[3].pose, PATH[3], atol=1e-9)
    with pytest.raises(UnusableFrame, match="no pose at"):
        sequence[4]


@pytest.mark.parametrize(("unit", "unit_s"), [("milliseconds", 1e-3), ("microseconds", 1e-6), ("nanoseconds", 1e-9)])
@pytest.mark.parametrize(("n", "gap_s"), [(N, 1 / 30), (200, 0.005)])
def test_stamps_in_another_unit_are_told_to_be(n, gap_s, unit, unit_s, folder, tmp_path):
    """Also where the first lies with the recording's, as they begin at zero: frames would lie between two poses. And of
    motion capture, which has a rate of its own and goes on for longer."""
    path = write_tum_lines(tmp_path / "t.txt", [i * gap_s / unit_s for i in range(n)], curved_path(n))
    assert f"{unit}, it seems: write seconds" in refused(folder, path)


@pytest.mark.parametrize(("n", "gap_s"), [(2, 1.0), (40, 1.0), (2000, 1 / 200)])
def test_seconds_are_seconds_however_rare_poses_are_and_long_they_go_on(n, gap_s, folder, tmp_path):
    path = write_tum_lines(tmp_path / "t.txt", [i * gap_s for i in range(n)], curved_path(n))
    assert "interpolated" in open_sequence(folder, poses_from=path).poses_note


@pytest.mark.parametrize("gap_s", [0.004, 0.029])
def test_another_rate_is_interpolated(folder, tmp_path, gap_s):
    """Also one that is nearly that of the frames, 33 ms apart: nearest stamps are up to half a gap beside."""
    stamps = np.arange(0.0, 0.2, gap_s)
    poses = [np.eye(4) for _ in stamps]
    for pose, stamp in zip(poses, stamps, strict=True):
        pose[0, 3] = 3 * stamp
    sequence = open_sequence(folder, poses_from=write_tum_lines(tmp_path / "t.txt", stamps.tolist(), poses))
    assert "interpolated" in sequence.poses_note
    assert [sequence[i].pose[0, 3] for i in range(N)] == pytest.approx([0.1 * i for i in range(N)], abs=1e-9)


def test_poses_far_from_zero_have_a_local_origin_and_implausible_ones_are_told(folder, tmp_path):
    far = [pose.copy() for pose in PATH]
    for pose in far:
        pose[:3, 3] += (500_000.0, 4_000_000.0, 0.0)
    far[2][:3, 3] += 30_000.0
    sequence = open_sequence(folder, poses_from=write_kitti(tmp_path / "k.txt", far))
    assert sequence.origin == (500_000.0, 4_000_000.0, 0.0)
    np.testing.assert_allclose(sequence[1].pose, PATH[1], atol=1e-6)
    with pytest.raises(UnusableFrame, match="km from the others"):
        sequence[2]


def test_a_pose_that_is_none_costs_its_frame_alone(folder, tmp_path):
    broken = [pose.copy() for pose in PATH]
    broken[1][0, 0], broken[2][:3, :3] = np.nan, 2 * np.eye(3)
    sequence = open_sequence(folder, poses_from=write_transforms(tmp_path / "transforms.json", NAMES, broken))
    for index, reason in ((1, "not finite"), (2, "not orthonormal")):
        with pytest.raises(UnusableFrame, match=reason):
            sequence[index]
    assert f"{N - 2} of {N} frames" in sequence.poses_note


def test_poses_of_colour_images_are_brought_to_the_depth_camera(folder, tmp_path):
    extrinsic = np.eye(4)
    extrinsic[:3, 3] = 0.05, 0.01, 0.0
    np.savetxt(tmp_path / "extrinsic.txt", extrinsic)
    path = write_colmap(tmp_path / "images.txt", NAMES, PATH)
    sequence = open_sequence(folder, poses_from=path, depth_to_color=tmp_path / "extrinsic.txt")
    # A point of the depth camera is the same in the world by way of the colour camera.
    np.testing.assert_allclose(sequence[2].pose, PATH[2] @ extrinsic, atol=1e-9)


def test_of_images_of_one_name_those_of_the_colour_folder_are_meant(folder, tmp_path):
    both = [*(f"left/{name}" for name in NAMES), *(f"color/{name}" for name in NAMES)]
    others = [np.eye(4)] * N
    path = write_colmap(tmp_path / "images.txt", both, [*others, *PATH])
    np.testing.assert_allclose(open_sequence(folder, poses_from=path)[4].pose, PATH[4], atol=1e-9)
    again = write_colmap(tmp_path / "twice.txt", [*NAMES, NAMES[0]], [*PATH, PATH[0]])
    assert "two poses for one image" in refused(folder, again)


@pytest.mark.parametrize("scale", [0.002, 0.07, 0.4, 1.0, 8.0, 1000.0])
def test_the_scale_of_colmap_is_measured_by_depth(scale, real_data, tmp_path):
    """A real kitchen, every tenth image of which has a pose: those of KinectFusion in another unit."""
    folder = real_data / "redkitchen"
    numbers = range(0, 600, 10)
    poses = [np.loadtxt(folder / f"frame-{n:06d}.pose.txt") for n in numbers]
    for pose in poses:
        pose[:3, 3] *= scale
    path = write_colmap(tmp_path / "images.txt", [f"frame-{n:06d}.color.jpg" for n in numbers], poses)
    sequence = open_sequence(folder, poses_from=path)
    assert ("as depth confirms" in sequence.poses_note) == (scale == 1)
    own = open_sequence(folder)
    way, true_way = (np.linalg.norm(s[300].pose[:3, 3] - s[0].pose[:3, 3]) for s in (sequence, own))
    assert way == pytest.approx(true_way, rel=0.02)


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("", "no file of poses that is known"),
        ("what is this\n", "it begins with 'what is this'"),
        ("1 2 3\n", "TUM"),
        ("9000 0 0 0 0 0 0 1\n9001 0 0 0 0 0 0 1\n", "none of the recording's, 0.000 to 0.167 s"),
        ("0 0 0 0 0 0 0 1\nno 0 0 0 0 0 0 1\n", "stamp tx ty tz qx qy qz qw"),
        ("0 0 0 0 0 0 0 0\n0.0333333 0 0 0 0 0 0 0\n", "has length 0"),
        ("1 0 0 0 0 1 0 0 0 0 1 0\n", f"1 poses for {N} frames"),
        ("1 0 0 0 0 1 0 0 0 0 1 0\n" * 5 + "1 0 0\n", "line 6: expected 12 numbers, got 3"),
        ("1 0 0 0 0 1 0 0 0 0 1 0\n" * 5 + "1 0 0 x\n", "line 6: expected 12 numbers, got '1 0 0 x'"),
        ("1 1 0 0 0 0 0 0 1 a.png\n\n2 1 0 0\n\n", "line 3: expected `id qw qx qy qz tx ty tz camera name`"),
        ("1 1 0 0 0 0 0 0 1 000000.png\n2 1 0 0 0 0 0 0 1 000001.png\n", "line 2: each image has two lines"),
        ("1 1 0 0 0 0 0 0 1 a.png\n\n", "('a.png' there, '000000.png' here)"),
        ("1 2 0 0 0 0 0 0 1 000000.png\n\n", "the pose is not finite"),
        ("{}", 'without a list "frames"'),
        ('{"frames": []}', "it holds no pose"),
        ('{"frames": [{"file_path": "000000.png"}]}', "frames[0] needs a file_path and a transform_matrix"),
        ('{"frames": [{"file_path": "a", "transform_matrix": [[1, 0], [0, 1]]}]}', "frames[0]: its transform_matrix"),
        ('{"frames": [', "line 1, column 13 is not JSON"),
    ],
)
def test_a_file_that_cannot_be_used_is_one_plain_line(text, message, folder, tmp_path):
    (tmp_path / "poses").write_text(text)
    assert message in refused(folder, tmp_path / "poses")


def test_what_is_no_file_is_told(folder, tmp_path):
    assert "No such file" in refused(folder, tmp_path / "missing.txt")
    assert "is a folder" in refused(folder, tmp_path)
    (tmp_path / "images.bin").write_bytes(b"\2\0\0\0\0\0\0\0\x80\xff")
    assert "is no file of poses that is known" in refused(folder, tmp_path / "images.bin")


class Nameless(ImageSource):
    """Images as those of one file, which have no names of their own."""

    def __init__(self, images):
        self.stamp, self.color, self.depth, self._n = images.stamp, images.color, images.depth, len(images)

    def __len__(self):
        return self._n


def test_poses_by_names_need_images_that_have_some(folder, tmp_path):
    sequence = open_sequence(folder)
    nameless = replace(sequence, images=Nameless(sequence.images))
    with pytest.raises(BadInput, match=r"which this recording has none of: .*razer convert"):
        posed_by(nameless, write_transforms(tmp_path / "transforms.json", NAMES, PATH))
    posed = posed_by(nameless, write_kitti(tmp_path / "k.txt", PATH))
    np.testing.assert_allclose(posed[3].pose, PATH[3], atol=1e-9)


def test_a_reader_of_ones_own_poses_its_frames_itself(tmp_path):
    with pytest.raises(BadInput, match="a reader of your own, which alone can pose its frames"):
        posed_by(SyntheticRoom(0, 2, 32, 24), write_kitti(tmp_path / "k.txt", PATH))


@pytest.mark.parametrize(
    ("late_s", "said"), [(0.010, "nearest stamps, 0.010 s off at the median"), (0.001, "nearest stamps)")]
)
def test_stamps_that_are_all_late_are_said_to_be(folder, tmp_path, late_s, said):
    late = [i / 30 + late_s for i in range(N)]
    assert said in open_sequence(folder, poses_from=write_tum_lines(tmp_path / "t.txt", late, PATH)).poses_note


@pytest.mark.parametrize(("shift_m", "turn_deg"), [(0.0, 0.0), (0.005, 0.5), (0.02, 0.0), (0.0, 2.0)])
def test_one_stamp_has_one_pose(folder, tmp_path, shift_m, turn_deg):
    again = PATH[2] @ exp_se3(np.array([0, np.radians(turn_deg), 0, shift_m, 0, 0]))
    stamps = [i / 30 for i in range(N)]
    path = write_tum_lines(tmp_path / "t.txt", [*stamps, stamps[2]], [*PATH, again])
    if shift_m < 0.01 and turn_deg < 1:
        np.testing.assert_allclose(open_sequence(folder, poses_from=path)[1].pose, PATH[1], atol=1e-9)
    else:
        assert "the stamp 0.066667 has two poses" in refused(folder, path)


def test_comments_are_no_poses(folder, tmp_path):
    path = write_kitti(tmp_path / "k.txt", PATH)
    path.write_text("# first\n" + path.read_text() + "  # last\n")
    np.testing.assert_allclose(open_sequence(folder, poses_from=path)[N - 1].pose, PATH[-1], atol=1e-9)


def test_a_line_that_is_no_pose_is_named_by_its_number(folder, tmp_path):
    path = write_tum_lines(tmp_path / "t.txt", [i / 30 for i in range(N)], PATH)
    lines = path.read_text().splitlines()
    lines[3] = lines[3].rpartition(" ")[0]
    path.write_text("\n".join(lines) + "\n")
    assert f"{path}, line 4: every line must read" in refused(folder, path)
