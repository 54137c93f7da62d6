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
from razer.metrics.umeyama import align_positions, align_views, umeyama


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


# Alignment by full poses


def flat_walk(n: int = 200) -> np.ndarray:
    """Poses of a hand-held camera whose path spreads by 30, 11 and 1 cm, as that of a real kitchen does."""
    t = np.linspace(0, 2 * np.pi, n)
    turns = Rotation.from_rotvec(np.stack([0.2 * np.sin(2 * t), 0.5 * np.sin(t), 0.1 * np.cos(t)], axis=1))
    shifts = np.stack([0.42 * np.sin(t), 0.155 * np.cos(2 * t), 0.014 * np.cos(5 * t)], axis=1)
    return np.stack([motion(r, s) for r, s in zip(turns, shifts, strict=True)])


def drifted(poses: np.ndarray) -> np.ndarray:
    """The same with errors that change slowly: 3 cm across the path where it is narrow, and a degree."""
    t = np.linspace(0, 2 * np.pi, len(poses))
    moved = poses.copy()
    moved[:, 2, 3] += 0.04 * np.cos(2 * t)  # in step with the path's width: positions alone take it for a turn
    errors = Rotation.from_rotvec(np.radians(1.0) * np.stack([np.sin(3 * t), np.cos(t), np.sin(t)], axis=1))
    moved[:, :3, :3] = (errors * Rotation.from_matrix(poses[:, :3, :3])).as_matrix()
    return moved


def turn_deg(transform: np.ndarray) -> float:
    return float(np.degrees(Rotation.from_matrix(transform[:3, :3]).magnitude()))


def test_a_nearly_flat_path_is_aligned_by_where_the_camera_looked() -> None:
    true_poses = flat_walk()
    moved = motion(Rotation.random(random_state=2), np.array([1.0, -2.0, 0.5]))
    poses = moved @ drifted(true_poses)
    by_positions = align_positions(poses, true_poses)
    assert by_positions.basis == "positions"
    assert turn_deg(by_positions.target_from_source @ moved) > 5
    assert by_positions.degenerate is not None
    assert "nearly flat" in by_positions.degenerate
    assert turn_deg(align_views(poses, true_poses) @ moved) < 1.5
    stamps = np.arange(len(poses)) / 30
    result = trajectory_metrics(TimedPoses(stamps, true_poses), TimedPoses(stamps, poses))
    assert result is not None
    assert result.rotation_rmse_deg < 2
    assert result.truth_from_estimate == pytest.approx(align_views(poses, true_poses))
    assert result.by_positions.degenerate == by_positions.degenerate


@pytest.mark.parametrize("direction", [(0.0, 0.0, 0.0), (1.0, 0.5, 0.0), (1.0, 0.001, 0.0)])
@pytest.mark.parametrize("n", [1, 2, 60])
def test_no_path_is_too_short_or_straight_for_full_poses(direction: tuple[float, ...], n: int) -> None:
    poses = walk(n).world_from_camera.copy()
    poses[:, :3, 3] = np.outer(np.linspace(0, 2, n), direction)
    moved = motion(Rotation.random(random_state=5), np.array([1.0, -2.0, 3.0]))
    assert align_views(moved @ poses, poses) @ moved == pytest.approx(np.eye(4), abs=1e-9)


def test_a_stretch_of_wrong_poses_does_not_pull_the_alignment() -> None:
    true_poses, moved = walk(100).world_from_camera, motion(Rotation.random(random_state=3), np.array([1.0, 0.0, 2.0]))
    poses = moved @ true_poses
    poses[60:90] = poses[60:90] @ motion(Rotation.from_euler("y", 25, degrees=True), np.array([0.6, 0.0, 0.3]))
    off = align_views(poses, true_poses) @ moved
    assert turn_deg(off) < 0.01
    assert np.linalg.norm(off[:3, 3]) < 1e-4


def test_no_motion_displaces_what_was_seen_less() -> None:
    true_poses = walk(30).world_from_camera
    poses = drifted(true_poses)
    corners = np.array([[0, 0, 2], [-1, -0.75, 2], [1, -0.75, 2], [-1, 0.75, 2], [1, 0.75, 2]])

    def displacements(parameters: np.ndarray) -> np.ndarray:
        moved = motion(Rotation.from_rotvec(parameters[:3]), parameters[3:]) @ poses
        off = [(t[:3, :3] - m[:3, :3]) @ corners.T + (t - m)[:3, 3:] for t, m in zip(true_poses, moved, strict=True)]
        return np.array([np.sqrt((one**2).sum(axis=0).mean()) for one in off])

    def huber(parameters: np.ndarray, scale_m: float) -> float:
        return sum(d if d > scale_m else (d**2 / scale_m + scale_m) / 2 for d in displacements(parameters))

    options = {"maxiter": 6000, "fatol": 1e-10, "xatol": 1e-8}
    robust = minimize(lambda p: displacements(p).sum(), np.zeros(6), method="Nelder-Mead", options=options).x
    scale_m = 2 * float(np.median(displacements(robust)))
    best = minimize(huber, robust, (scale_m,), method="Nelder-Mead", options=options).fun
    result = align_views(poses, true_poses)
    found = huber(np.append(Rotation.from_matrix(result[:3, :3]).as_rotvec(), result[:3, 3]), scale_m)
    assert found == pytest.approx(best, rel=1e-4)


@pytest.mark.parametrize(
    ("n", "spreads_m", "error_m", "cause"),
    [
        (2, (1.0, 1.0, 1.0), 0.01, "too few poses in common (2)"),
        (40, (0.01, 0.005, 0.002), 0.001, "hardly moved"),
        (40, (1.0, 0.01, 0.005), 0.001, "straight to within"),
        (40, (1.0, 0.05, 0.005), 0.02, "nearly straight"),
        (40, (0.3, 0.11, 0.01), 0.02, "nearly flat"),
        (40, (0.1, 0.1, 0.1), 0.02, "short"),
        (40, (1.0, 0.7, 0.01), 0.005, None),
        (40, (0.3, 0.11, 0.01), 0.001, None),
    ],
)
def test_positions_that_hardly_align_are_named_with_their_cause(
    n: int, spreads_m: tuple[float, ...], error_m: float, cause: str | None
) -> None:
    rng = np.random.default_rng(0)
    path = rng.normal(size=(n, 3))
    path = (path - path.mean(axis=0)) / path.std(axis=0)
    poses = np.tile(np.eye(4), (n, 1, 1))
    poses[:, :3, 3] = path * spreads_m
    other = poses.copy()
    other[:, :3, 3] += error_m * rng.normal(size=(n, 3)) / np.sqrt(3)
    found = align_positions(other, poses).degenerate
    assert found is None if cause is None else cause in str(found)
