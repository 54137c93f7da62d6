"""Errors of trajectories: planted motions and errors with known sizes, invariances, and stamps that do not agree."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.optimize import minimize
from scipy.spatial.transform import Rotation

from razer.metrics.scene_pair import TimedPoses
from razer.metrics.trajectory_errors import match_timestamps, trajectory_metrics
from razer.metrics.umeyama import align_positions, umeyama


def motion(rotation: Rotation, shift: np.ndarray) -> np.ndarray:
    matrix = np.eye(4)
    matrix[:3, :3], matrix[:3, 3] = rotation.as_matrix(), shift
    return matrix


def walk(n: int = 90, rate: float = 30.0, seed: int = 0) -> TimedPoses:
    rng = np.random.default_rng(seed)
    t = np.arange(n) / rate
    rotations = Rotation.from_rotvec(np.stack([0.3 * np.sin(t), t, 0.2 * np.cos(2 * t)], axis=1))
    shifts = np.stack([np.sin(t), np.cos(1.3 * t), 0.4 * t], axis=1) + 0.01 * rng.normal(size=(n, 3))
    return TimedPoses(t, np.stack([motion(r, s) for r, s in zip(rotations, shifts, strict=True)]))


@settings(max_examples=20, deadline=None)
@given(st.integers(0, 100_000))
def test_a_rigid_motion_of_all_poses_costs_nothing(seed: int) -> None:
    truth = walk()
    moved = motion(Rotation.random(random_state=seed), np.random.default_rng(seed).normal(size=3))
    result = trajectory_metrics(truth, TimedPoses(truth.stamps, moved @ truth.world_from_camera))
    assert result is not None
    assert result.ate_rmse_m == pytest.approx(0, abs=1e-9)
    assert result.rotation_rmse_deg == pytest.approx(0, abs=1e-6)
    assert result.per_frame.translation_m == pytest.approx(0, abs=1e-9)
    assert result.per_second.rotation_deg == pytest.approx(0, abs=1e-6)
    assert result.truth_from_estimate @ moved == pytest.approx(np.eye(4), abs=1e-9)
    assert result.tracked == 1.0


def test_no_motion_aligns_better() -> None:
    rng = np.random.default_rng(3)
    source = rng.normal(size=(20, 3))
    target = source @ Rotation.random(random_state=1).as_matrix().T + 1 + 0.1 * rng.normal(size=(20, 3))

    def error(parameters: np.ndarray) -> float:
        moved = source @ Rotation.from_rotvec(parameters[:3]).as_matrix().T + parameters[3:]
        return float(((moved - target) ** 2).sum())

    best = min(minimize(error, np.append(Rotation.random(random_state=i).as_rotvec(), [1, 1, 1])).fun for i in range(4))
    result = umeyama(source, target)
    assert error(np.append(Rotation.from_matrix(result[:3, :3]).as_rotvec(), result[:3, 3])) == pytest.approx(best)


def test_a_mirror_is_no_rotation_and_scale_is_not_forgiven() -> None:
    points = np.random.default_rng(0).normal(size=(10, 3))
    assert np.linalg.det(umeyama(points, points * [1, 1, -1])[:3, :3]) == pytest.approx(1.0)
    truth = walk()
    larger = truth.world_from_camera.copy()
    larger[:, :3, 3] *= 1.1
    result = trajectory_metrics(truth, TimedPoses(truth.stamps, larger))
    assert result is not None
    spread = truth.world_from_camera[:, :3, 3] - truth.world_from_camera[:, :3, 3].mean(axis=0)
    assert result.ate_rmse_m == pytest.approx(0.1 * math.sqrt((spread**2).sum(axis=1).mean()), rel=1e-6)


def test_a_drift_of_known_size_per_frame_and_per_second() -> None:
    # Straight ahead with 1 mm and 0.1 degrees too much in every frame.
    n, rate = 91, 30.0
    step = motion(Rotation.identity(), np.array([0.02, 0, 0]))
    wrong = motion(Rotation.from_euler("z", 0.1, degrees=True), np.array([0.021, 0, 0]))
    true_poses = [np.linalg.matrix_power(step, i) for i in range(n)]
    poses = [np.linalg.matrix_power(wrong, i) for i in range(n)]
    stamps = np.arange(n) / rate
    result = trajectory_metrics(TimedPoses(stamps, np.stack(true_poses)), TimedPoses(stamps, np.stack(poses)))
    assert result is not None
    assert result.per_frame.pairs == 90
    assert result.per_frame.translation_m == pytest.approx(0.001, rel=1e-6)
    assert result.per_frame.rotation_deg == pytest.approx(0.1, rel=1e-6)
    assert result.per_second.pairs == 61
    assert result.per_second.rotation_deg == pytest.approx(3.0, rel=1e-6)
    expected = np.linalg.inv(np.linalg.matrix_power(step, 30)) @ np.linalg.matrix_power(wrong, 30)
    assert result.per_second.translation_m == pytest.approx(np.linalg.norm(expected[:3, 3]), rel=1e-9)


def test_one_wrong_rotation() -> None:
    truth = walk(40)
    poses = truth.world_from_camera.copy()
    poses[7, :3, :3] = poses[7, :3, :3] @ Rotation.from_euler("x", 180, degrees=True).as_matrix()
    result = trajectory_metrics(truth, TimedPoses(truth.stamps, poses))
    assert result is not None
    assert result.ate_rmse_m == pytest.approx(0, abs=1e-9)
    assert result.rotation_rmse_deg == pytest.approx(180 / math.sqrt(40), rel=1e-6)


def test_stamps_belong_to_the_nearest_and_only_once() -> None:
    rows, columns = match_timestamps(np.array([0.0, 1.0, 2.0, 3.0]), np.array([0.012, 0.99, 1.004, 2.021]), 0.02)
    assert rows.tolist() == [0, 1]
    assert columns.tolist() == [0, 2]
    rows, columns = match_timestamps(np.array([1.0]), np.array([1.02]), 0.02)  # the limit itself counts
    assert rows.tolist() == [0]


def test_lost_frames_count_and_no_common_stamp_gives_nothing() -> None:
    truth = walk(60)
    seen = TimedPoses(truth.stamps[:45], truth.world_from_camera[:45])
    result = trajectory_metrics(TimedPoses(truth.stamps, truth.world_from_camera, 90), seen)
    assert result is not None
    assert result.tracked == 0.5
    assert result.compared == 45
    assert trajectory_metrics(truth, TimedPoses(truth.stamps + 100, truth.world_from_camera)) is None


def test_short_trajectories() -> None:
    truth = walk(1)
    result = trajectory_metrics(truth, truth)
    assert result is not None
    assert result.ate_rmse_m == pytest.approx(0)
    assert math.isnan(result.per_frame.translation_m)
    assert result.per_second.pairs == 0
    with pytest.raises(ValueError, match="must increase"):
        TimedPoses(np.array([1.0, 1.0]), np.stack([np.eye(4)] * 2))
    with pytest.raises(ValueError, match="one 4x4 each"):
        TimedPoses(np.array([1.0]), np.eye(4))


def test_what_was_written_and_read_back_is_left_where_it_is() -> None:
    poses = walk().world_from_camera
    result = align_positions(poses + 1e-9, poses)
    assert result.basis == "identity"
    assert (result.target_from_source == np.eye(4)).all()


@pytest.mark.parametrize("direction", [(0.0, 0.0, 0.0), (1.0, 0.5, 0.0)], ids=["standing still", "straight on"])
def test_orientations_close_what_positions_leave_open(direction: tuple[float, ...]) -> None:
    poses = walk(60).world_from_camera.copy()
    poses[:, :3, 3] = np.outer(np.linspace(0, 2, 60), direction)
    moved = motion(Rotation.random(random_state=5), np.array([1.0, -2.0, 3.0]))
    result = align_positions(moved @ poses, poses)
    assert result.basis == "orientations"
    assert result.target_from_source @ moved == pytest.approx(np.eye(4), abs=1e-9)
