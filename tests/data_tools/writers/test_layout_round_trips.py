"""What the writers write is what the layouts ask for, and what the readers read back."""

from __future__ import annotations

import pickle
import re
from pathlib import Path

import cv2
import numpy as np
import open3d as o3d
import pytest
from scipy.spatial.transform import Rotation

from data_tools.recordings.sequence import RgbdSequence
from data_tools.registry import open_sequence, recognise
from data_tools.synthetic.synthetic_room import FRAMES_PER_S, SyntheticRoom
from data_tools.writers.table import WRITERS, write_recording
from razer.errors import BadInput, UnusableFrame
from razer.frame import Frame, Intrinsics

N_FRAMES = 4
READER_OF = {"own": "folder"}
# Metres that depth may be off by rounding, and seconds that stamps may be off: None = the layout has no stamps.
DEPTH_STEP_M = {"tum": 1 / 5000}
STAMP_STEP_S: dict[str, float | None] = {"7scenes": None, "scannet": None, "replica": None}


@pytest.fixture(scope="module")
def room() -> SyntheticRoom:
    return SyntheticRoom(0, N_FRAMES, 64, 48)


@pytest.fixture(scope="module", params=WRITERS)
def written(request: pytest.FixtureRequest, room: SyntheticRoom, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The room in each layout; the folder is called by the layout."""
    folder = tmp_path_factory.mktemp("written") / request.param
    assert write_recording(room, folder, request.param, lossless=True) == []
    return folder


def test_it_is_recognised_and_read_back(written: Path, room: SyntheticRoom) -> None:
    layout = written.name
    assert recognise(written) == READER_OF.get(layout, layout)
    sequence = pickle.loads(pickle.dumps(open_sequence(written)))
    assert (len(sequence), sequence.has_poses) == (N_FRAMES, True)
    step = DEPTH_STEP_M.get(layout, 1 / 1000)
    for i in (2, 0, 3, 1):
        frame, truth = sequence[i], room[i]
        np.testing.assert_allclose(frame.pose, truth.pose, atol=1e-6)
        np.testing.assert_allclose(frame.depth, truth.depth, atol=step / 2 + 1e-5)
        assert_colors(frame, truth, layout)
        np.testing.assert_allclose(frame.intrinsics.matrix, truth.intrinsics.matrix, atol=1e-4)
        if (precision := STAMP_STEP_S.get(layout, 1e-6)) is not None:
            assert frame.stamp == pytest.approx(i / FRAMES_PER_S, abs=precision)


def assert_colors(frame: Frame, truth: Frame, layout: str) -> None:
    if layout in ("scannet", "replica"):  # these layouts have JPEG
        assert np.abs(frame.rgb.astype(int) - truth.rgb).mean() < 8
    else:
        np.testing.assert_array_equal(frame.rgb, truth.rgb)


class Faulty:
    """A recording with depths from 2 cm to 90 m and none, whose second frame is damaged."""

    name, has_poses, depth_scale = "faulty", True, 1.0
    intrinsics = Intrinsics(8, 6, 10, 10, 3.5, 2.5)

    def __len__(self) -> int:
        return 3

    def __getitem__(self, index: int) -> Frame:
        if index == 1:
            raise UnusableFrame("damaged")
        depth = np.tile(np.float32([0, 0.02, 1, 13.0, 13.2, 65.0, 66.0, 90.0]), (6, 1))
        pose = np.eye(4)
        pose[:3, :3] = Rotation.from_euler("xyz", [10, 20, 30 * index], degrees=True).as_matrix()
        rgb = np.full((6, 8, 3), 40 * index, np.uint8)
        return Frame(index, 100 + index / 10, rgb, depth, self.intrinsics, pose)


@pytest.fixture(scope="module", params=WRITERS)
def faulty(request: pytest.FixtureRequest, tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("faulty") / request.param
    assert write_recording(Faulty(), folder, request.param) == [(1, "damaged")]
    return folder


def test_a_damaged_frame_is_left_out_and_depth_beyond_the_files_is_none(faulty: Path) -> None:
    sequence = open_sequence(faulty)
    assert len(sequence) == 2
    np.testing.assert_allclose(sequence[1].pose, Faulty()[2].pose, atol=1e-6)
    reach_m = {"tum": 13.1, "replica": 10.0}.get(faulty.name, 65.5)
    metres = Faulty()[0].depth[0]
    expected = np.where(metres < reach_m, metres, 0)
    np.testing.assert_allclose(sequence[0].depth[0], expected, atol=1e-3)


def test_nothing_appears_where_nothing_can_be_written(tmp_path: Path, room: SyntheticRoom) -> None:
    class Broken(Faulty):
        def __getitem__(self, index: int) -> Frame:
            raise UnusableFrame("damaged")

    for layout in WRITERS:
        with pytest.raises(BadInput, match="none of 3 frames can be used, first frame 0: damaged"):
            write_recording(Broken(), tmp_path / layout, layout)
        (tmp_path / "there").mkdir(exist_ok=True)
        with pytest.raises(BadInput, match="exists"):
            write_recording(room, tmp_path / "there", layout)
    assert [path.name for path in tmp_path.iterdir()] == ["there"]


def test_a_bug_leaves_no_half_written_folder(tmp_path: Path) -> None:
    class Buggy(Faulty):
        def __getitem__(self, index: int) -> Frame:
            if index == 2:
                raise RuntimeError("a bug")
            return super().__getitem__(index)

    for layout in WRITERS:
        with pytest.raises(RuntimeError, match="a bug"):
            write_recording(Buggy(), tmp_path / layout, layout)
    assert list(tmp_path.iterdir()) == []


def raw(path: Path) -> np.ndarray:
    return cv2.imread(str(path), cv2.IMREAD_UNCHANGED)


# What follows reads the files by the words of each layout's own documentation, without the project's readers.


def test_tum_files_are_as_documented(tmp_path: Path) -> None:
    write_recording(Faulty(), tmp_path / "a", "tum")
    folder = tmp_path / "a"
    for part in ("rgb", "depth"):
        lines = (folder / f"{part}.txt").read_text().splitlines()
        assert [line[0] for line in lines[:3]] == ["#"] * 3
        assert lines[3:] == [f"100.000000 {part}/100.000000.png", f"100.200000 {part}/100.200000.png"]
    depth = raw(folder / "depth" / "100.200000.png")
    assert depth.dtype == np.uint16
    assert depth[0].tolist() == [0, 100, 5000, 65000, 0, 0, 0, 0]
    rows = [line.split() for line in (folder / "groundtruth.txt").read_text().splitlines() if line[0] != "#"]
    stamp, *position, qx, qy, qz, qw = (float(word) for word in rows[1])
    assert (stamp, position) == (100.2, [0, 0, 0])
    x, y, z, w = qx, qy, qz, qw
    first_column = [1 - 2 * (y * y + z * z), 2 * (x * y + z * w), 2 * (x * z - y * w)]
    np.testing.assert_allclose(first_column, Faulty()[2].pose[:3, 0], atol=1e-8)


def test_seven_scenes_files_are_as_documented(tmp_path: Path) -> None:
    write_recording(Faulty(), tmp_path / "a", "7scenes")
    names = {path.name for path in (tmp_path / "a").glob("frame-*")}
    assert names == {f"frame-00000{i}.{kind}" for i in (0, 1) for kind in ("color.png", "depth.png", "pose.txt")}
    depth = raw(tmp_path / "a" / "frame-000001.depth.png")
    assert depth[0].tolist() == [65535, 20, 1000, 13000, 13200, 65000, 65535, 65535]
    pose = np.array((tmp_path / "a" / "frame-000001.pose.txt").read_text().split(), float).reshape(4, 4)
    np.testing.assert_allclose(pose, Faulty()[2].pose, atol=1e-8)


def test_scenenn_files_are_as_its_playback_tool_writes_them(tmp_path: Path) -> None:
    write_recording(Faulty(), tmp_path / "005", "scenenn")
    folder = tmp_path / "005"
    assert {path.name for path in (folder / "image").iterdir()} == {"image00001.png", "image00002.png"}
    assert raw(folder / "depth" / "depth00002.png")[0].tolist() == [0, 20, 1000, 13000, 13200, 65000, 0, 0]
    assert (folder / "timestamp.txt").read_text() == "1 100000000 100000000\n2 100200000 100200000\n"
    lines = (folder / "trajectory.log").read_text().splitlines()
    assert len(lines) == 10
    assert [re.split(r"\s+", line) for line in lines[::5]] == [["0", "0", "1"], ["1", "1", "2"]]
    matrix = np.array([line.split() for line in lines[6:]], float)
    np.testing.assert_allclose(matrix, Faulty()[2].pose, atol=1e-8)
    # Open3D reads the same log, as the inverse of the pose.
    theirs = o3d.io.read_pinhole_camera_trajectory(str(folder / "trajectory.log")).parameters
    np.testing.assert_allclose(np.linalg.inv(theirs[1].extrinsic), Faulty()[2].pose, atol=1e-6)


def test_a_recording_without_poses_stays_without(tmp_path: Path) -> None:
    class Unposed(Faulty):
        has_poses = False

        def __getitem__(self, index: int) -> Frame:
            frame = super().__getitem__(index)
            return Frame(index, frame.stamp, frame.rgb, frame.depth, frame.intrinsics)

    for layout in ("own", "tum", "scenenn", "7scenes"):
        write_recording(Unposed(), tmp_path / layout, layout)
        sequence: RgbdSequence = open_sequence(tmp_path / layout)
        assert (sequence.has_poses, sequence[0].world_from_camera) == (False, None)
