"""Poses: what is accepted, repaired and refused, and interpolation against poses worked out by hand."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from data_tools.recordings.trajectories import PROJECTED, Trajectory, checked_pose, read_pose, read_trajectory
from razer.errors import BadInput, UnusableFrame
from razer.geometry import is_rigid


def pose_of(rotation: np.ndarray, position: tuple[float, float, float] = (1, 2, 3)) -> np.ndarray:
    pose = np.eye(4)
    pose[:3, :3], pose[:3, 3] = rotation, position
    return pose


def test_a_rigid_pose_passes_unchanged() -> None:
    pose = pose_of(Rotation.from_euler("xyz", [0.3, -1, 2]).as_matrix())
    checked, notes = checked_pose(pose, "file")
    np.testing.assert_array_equal(checked, pose)
    assert notes == ()


@given(st.floats(0.0001, 0.0049), st.integers(0, 2**31))
def test_small_errors_are_projected_onto_the_nearest_rotation(stretch: float, seed: int) -> None:
    rotation = Rotation.random(random_state=seed).as_matrix()
    checked, notes = checked_pose(pose_of(rotation * (1 + stretch)), "file")
    assert notes == ((PROJECTED,) if (1 + stretch) ** 2 - 1 > 1e-3 else ())  # what is no more than rounding is not told
    assert is_rigid(checked)
    np.testing.assert_allclose(checked[:3, :3], rotation, atol=1e-9)  # a scaling is undone exactly
    np.testing.assert_array_equal(checked[:3, 3], (1, 2, 3))


@pytest.mark.parametrize(
    ("pose", "why"),
    [
        (np.full((4, 4), -np.inf), "not finite"),  # ScanNet
        (pose_of(np.eye(3), (np.nan, 0, 0)), "not finite"),
        (pose_of(np.zeros((3, 3))), "rotation is zero"),  # SceneNN
        (pose_of(np.eye(3) * 1.006), "not orthonormal"),  # max|R'R - I| = 0.012
        (pose_of(np.diag([1.0, 1.0, -1.0])), "left-handed"),
        (np.vstack([np.eye(4)[:3], [0, 0, 0, 2]]), "last row"),
        (np.eye(4).T + np.eye(4, k=-3), "last row"),
        (np.eye(3), "4x4"),
    ],
)
def test_unusable_poses_say_why_and_where(pose: np.ndarray, why: str) -> None:
    with pytest.raises(UnusableFrame, match=f"frame-7.*{why}"):
        checked_pose(pose, "frame-7.pose.txt")


@pytest.mark.parametrize(
    ("text", "why"), [("1 2 3", "3 numbers"), ("a b", "not a 4x4"), ("", "0 numbers"), (None, "missing")]
)
def test_unreadable_pose_files_name_themselves(tmp_path: Path, text: str | None, why: str) -> None:
    path = tmp_path / "frame-000003.pose.txt"
    if text is not None:
        path.write_text(text)
    with pytest.raises(UnusableFrame, match=rf"frame-000003\.pose\.txt.*{why}"):
        read_pose(path)


@pytest.fixture
def quarter_turn() -> Trajectory:
    """From the identity at t = 10 s to 90 degrees about z and (1, 2, 0) at t = 10.1 s; the next is far off."""
    s = np.sqrt(0.5)
    quaternions = np.array([[0, 0, 0, 1], [0, 0, -s, -s], [0, 0, -s, -s]])  # -q is the same rotation as q
    return Trajectory(
        "groundtruth.txt", np.array([10.0, 10.1, 11.0]), np.array([[0.0, 0, 0], [1, 2, 0], [1, 2, 0]]), quaternions
    )


@pytest.mark.parametrize(("share", "degrees"), [(0.0, 0.0), (0.25, 22.5), (0.5, 45.0), (1.0, 90.0)])
def test_interpolation_turns_at_constant_speed(quarter_turn: Trajectory, share: float, degrees: float) -> None:
    pose, _ = quarter_turn.interpolated(10.0 + 0.1 * share)
    expected = Rotation.from_euler("z", degrees, degrees=True).as_matrix()
    np.testing.assert_allclose(pose[:3, :3], expected, atol=1e-9)
    np.testing.assert_allclose(pose[:3, 3], [share, 2 * share, 0], atol=1e-9)


@pytest.mark.parametrize(("stamp", "why"), [(9.9, "cover"), (11.1, "cover"), (10.5, "gap of 0.90 s")])
def test_no_pose_is_invented(quarter_turn: Trajectory, stamp: float, why: str) -> None:
    with pytest.raises(UnusableFrame, match=why):
        quarter_turn.interpolated(stamp)


def test_nearest_wants_the_same_stamp(quarter_turn: Trajectory) -> None:
    np.testing.assert_allclose(quarter_turn.nearest(10.1009)[0][:3, 3], [1, 2, 0])
    with pytest.raises(UnusableFrame, match=r"no pose at 10\.102"):
        quarter_turn.nearest(10.102)


@pytest.mark.parametrize("quaternion", ["0 0 0 0", "1 1 0 0", "nan 0 0 1"])
def test_a_broken_quaternion_costs_its_own_frames_only(tmp_path: Path, quaternion: str) -> None:
    path = tmp_path / "trajectory.txt"
    path.write_text(f"# comment\n1 0 0 0 0 0 0 1\n\n2 0 0 0 {quaternion}\n0 5 0 0 0 0 0 1.0001\n")
    trajectory = read_trajectory(path)
    np.testing.assert_array_equal(trajectory.stamps, [0, 1, 2])  # sorted
    assert trajectory.nearest(0)[0][0, 3] == 5
    with pytest.raises(UnusableFrame, match="quaternion"):
        trajectory.nearest(2)


def test_a_trajectory_of_another_format_is_refused(tmp_path: Path) -> None:
    path = tmp_path / "trajectory.txt"
    path.write_text("1 0 0 0\n")
    with pytest.raises(BadInput, match=r"trajectory\.txt.*qx qy qz qw"):
        read_trajectory(path)
