"""Stamps and poses that no camera has: told apart frame by frame, and no walk, drive or flight is taken for one."""

from __future__ import annotations

import json
from functools import cache
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from data_tools import open_sequence
from data_tools.recordings.local_origin import HERE, local_origin, moved_origin
from data_tools.recordings.plausibility import _longest_rising, implausible_frames
from data_tools.recordings.trajectories import tum_line
from data_tools.synthetic.synthetic_room import SyntheticRoom
from data_tools.synthetic.synthetic_scene import SCENES, SyntheticScene
from razer.errors import BadInput, UnusableFrame
from tests.support.recordings import camera_json, write_folder

N = 60
PATH = Path("recording")
STAMPS = 100 + 0.0333 * np.arange(N)


def odd(stamps: np.ndarray, positions: np.ndarray | None, recorded_stamps: bool = True) -> dict[int, str]:
    return implausible_frames(PATH, stamps, positions, recorded_stamps=recorded_stamps)


def straight(speed_m_per_s: float, stamps: np.ndarray = STAMPS) -> np.ndarray:
    return np.stack([speed_m_per_s * (stamps - stamps[0]), 0 * stamps, 0 * stamps], axis=1)


@pytest.mark.parametrize("stride", range(1, 17))
@pytest.mark.parametrize("speed", [0.0, 0.5, 30.0, 45.0])
def test_what_walks_drives_or_flies_passes_with_bunched_stamps_too(speed: float, stride: int) -> None:
    positions = straight(speed, 100 + 0.0333 * np.arange(16 * N))[::stride]
    stamps = 100 + 0.0333 * np.arange(16 * N)[::stride]
    assert odd(stamps, positions) == {}
    late = stamps.copy()
    late[1::2] = np.nextafter(late[2::2], 0)[: len(late[1::2])] if len(late) % 2 else np.append(late[2::2], late[-1])
    assert odd(late, positions) == {}


@cache
def walked(scene: str) -> np.ndarray:
    """The positions of a walk through a scene, "" = the empty room: made once for all strides."""
    walk = SyntheticScene(scene, 3, 240, 64, 48) if scene else SyntheticRoom(3, 240, 64, 48)
    return walk._poses[:, :3, 3]


@pytest.mark.parametrize("stride", range(1, 17))
@pytest.mark.parametrize("scene", ["", *SCENES])
def test_synthetic_walks_pass(scene: str, stride: int) -> None:
    positions = walked(scene)[::stride]
    stamps = (5.123 + np.arange(len(walked(scene))) / 15)[::stride]
    assert odd(stamps, positions) == {}


@pytest.mark.parametrize("row", [0, 1, 30, N - 1])
@pytest.mark.parametrize(("away_m", "says"), [(100, "no camera moves that fast"), (20_000, "km from the others")])
def test_a_pose_far_off_costs_its_frame_alone(row: int, away_m: float, says: str) -> None:
    positions = straight(1.0)
    positions[row, 1] += away_m
    (index,), (reason,) = zip(*odd(STAMPS, positions).items(), strict=True)
    assert index == row
    assert says in reason


def test_speed_says_nothing_where_stamps_are_made_up() -> None:
    positions = straight(1.0)
    positions[30, 1] += 100
    assert odd(STAMPS, positions, recorded_stamps=False) == {}
    fast = straight(1000.0, np.arange(N) / 30)
    assert odd(np.arange(N) / 30, fast) == {}  # made up once, and then written as if they were a clock's


def test_a_camera_that_is_found_elsewhere_is_believed_once_it_can_be_there() -> None:
    positions = straight(1.0)
    positions[40:, 1] += 4.5
    assert list(odd(STAMPS, positions)) == [40, 41]  # 4.5 m take 0.09 s at 50 m/s: until the third frame


def test_poses_in_millimetres_are_refused_as_a_whole() -> None:
    with pytest.raises(BadInput, match=r"recording: .* 500 m/s: poses must be metres and stamps seconds"):
        odd(STAMPS, straight(500.0))


def test_stamps_that_are_none_or_go_back_cost_their_frames() -> None:
    stamps = STAMPS.copy()
    stamps[3], stamps[5], stamps[20], stamps[40] = np.nan, np.inf, stamps[10], 1e9
    assert sorted(odd(stamps, None)) == [3, 5, 20, 40]
    with pytest.raises(BadInput, match="no frame has a finite stamp"):
        odd(np.full(N, np.nan), None)


@given(st.lists(st.integers(0, 6), min_size=1, max_size=9))
def test_the_longest_rising_part_is_that_of_all_subsets(values: list[int]) -> None:
    kept = _longest_rising(np.array(values, np.float64))
    best = 0
    for mask in range(1 << len(values)):
        chosen = [value for bit, value in enumerate(values) if mask >> bit & 1]
        if chosen == sorted(chosen):
            best = max(best, len(chosen))
    assert kept.sum() == best
    assert (np.diff(np.array(values)[kept]) >= 0).all()


@pytest.mark.parametrize("shift", [(5e6, 4e5, 120.0), (-5e6, 0.0, -300.0)])
def test_a_map_far_away_gets_an_origin_of_whole_kilometres(shift: tuple[float, float, float]) -> None:
    points = np.random.default_rng(0).normal(size=(50, 3)) + shift
    points[3] = np.nan
    origin = local_origin(points)
    assert all(value % 1000 == 0 for value in origin)
    local = points - origin
    assert np.nanmax(np.abs(local)) < 600
    assert local_origin(local) == HERE
    pose = np.eye(4)
    pose[:3, 3] = points[0]
    np.testing.assert_allclose(moved_origin(pose, origin)[:3, 3], local[0])


def recording(folder: Path, shift: tuple[float, float, float], frames: int = 12) -> Path:
    write_folder(folder, frames, camera_json())
    poses = np.tile(np.eye(4), (frames, 1, 1))
    poses[:, :3, 3] = np.array(shift) + straight(1.0)[:frames]
    lines = [tum_line(float(stamp), pose) for stamp, pose in zip(STAMPS, poses, strict=False)]
    (folder / "trajectory.txt").write_text("\n".join(lines) + "\n")
    (folder / "stamps.txt").write_text("\n".join(f"{stamp:.6f}" for stamp in STAMPS[:frames]) + "\n")
    return folder


def test_a_recording_far_away_is_read_in_a_local_frame(tmp_path: Path) -> None:
    far, near = (
        open_sequence(recording(tmp_path / "a", (5e6, 4e5, 120))),
        open_sequence(recording(tmp_path / "b", HERE)),
    )
    assert (far.origin, near.origin) == ((5e6, 4e5, 0.0), HERE)
    for index in range(len(far)):
        np.testing.assert_allclose(far[index].pose[:3, 3] - near[index].pose[:3, 3], (0, 0, 120), atol=1e-6)


def test_stamps_that_are_nan_find_no_pose(tmp_path: Path) -> None:
    folder = recording(tmp_path, HERE)
    (folder / "stamps.txt").write_text("\n".join(["nan"] * 6 + [f"{s:.6f}" for s in STAMPS[6:12]]))
    sequence = open_sequence(folder)
    for index in range(6):
        with pytest.raises(UnusableFrame, match="stamp is nan"):
            sequence[index]
    assert sequence[6].pose[0, 3] == pytest.approx(6 * 0.0333)


@pytest.mark.parametrize("focal", [0.5, 100.0])
def test_focal_lengths_that_no_lens_has_are_refused(tmp_path: Path, focal: float) -> None:
    folder = recording(tmp_path, HERE)
    (folder / "intrinsics.json").write_text(json.dumps(camera_json() | {"fx": focal}))
    with pytest.raises(BadInput, match=r"focal lengths of .* are impossible for images 8 pixels wide"):
        open_sequence(folder)


def test_a_depth_scale_that_no_camera_has_is_refused(tmp_path: Path) -> None:
    with pytest.raises(BadInput, match=r"depth scale must be positive units per metre, at least 1e-06, not 1e-07"):
        open_sequence(recording(tmp_path, HERE), depth_scale=1e-7)
