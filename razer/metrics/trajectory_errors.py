"""Trajectory errors: absolute (ATE) after Umeyama alignment, of rotation after that by full poses, relative (RPE), and
the share of frames tracked."""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from razer.arrays import Float64Array, FloatArray, Int64Array, IntArray
from razer.metrics.scene_pair import TimedPoses
from razer.metrics.umeyama import PoseAlignment, align_positions, align_views

MAX_DIFFERENCE_S = 0.02


@dataclass(frozen=True, slots=True)
class RelativeErrors:
    """Root mean squares of the relative pose errors over `pairs` pairs of poses; nan without any."""

    translation_m: float
    rotation_deg: float
    pairs: int


@dataclass(frozen=True, slots=True)
class TrajectoryMetrics:
    """ate_rmse_m after `by_positions`, the alignment that belongs to it; rotation_rmse_deg after truth_from_estimate
    (4, 4), the alignment by full poses that brings maps together; errors from one frame to the next and over one
    second; poses compared; tracked, the share of the frames asked for that have an estimated pose, nan where
    the estimate does not know it."""

    ate_rmse_m: float
    rotation_rmse_deg: float
    per_frame: RelativeErrors
    per_second: RelativeErrors
    compared: int
    tracked: float
    truth_from_estimate: Float64Array
    by_positions: PoseAlignment


class PoseErrors(NamedTuple):
    """Stamps (N,) in seconds, and how far each estimated pose is from the true one: metres (N,), degrees (N,)."""

    stamps: FloatArray
    distances_m: FloatArray
    angles_deg: FloatArray


def trajectory_metrics(
    truth: TimedPoses, estimate: TimedPoses, max_difference_s: float = MAX_DIFFERENCE_S
) -> TrajectoryMetrics | None:
    """Compare trajectories (protocol E); None where no stamps agree. Sources: Sturm et al., IROS 2012; Umeyama 1991."""
    rows, columns = match_timestamps(truth.stamps, estimate.stamps, max_difference_s)
    if len(rows) == 0:
        return None
    stamps, true_poses, poses = truth.stamps[rows], truth.world_from_camera[rows], estimate.world_from_camera[columns]
    by_positions, by_views = align_positions(poses, true_poses), align_views(poses, true_poses)
    seconds = _one_second_later(stamps, max_difference_s)
    return TrajectoryMetrics(
        _root_mean_square(_distances_m(true_poses, by_positions.target_from_source @ poses)),
        _root_mean_square(_angles_deg(true_poses, by_views @ poses)),
        _relative(true_poses, poses, np.arange(len(poses) - 1), np.arange(1, len(poses))),
        _relative(true_poses, poses, *seconds),
        len(poses),
        len(poses) / (truth.n_frames or len(truth.stamps)) if estimate.tracked is None else estimate.tracked,
        by_views,
        by_positions,
    )


def errors_over_time(
    truth: TimedPoses, estimate: TimedPoses, metrics: TrajectoryMetrics, max_difference_s: float = MAX_DIFFERENCE_S
) -> PoseErrors:
    """The error of each estimated pose that has a true one at its stamp, after the alignments of its metrics.

    Args:
        truth: true poses, metres.
        estimate: estimated poses, metres, in a frame of their own.
        metrics: of the estimate against the truth.
        max_difference_s: stamps further apart than this do not agree, seconds.
    """
    rows, columns = match_timestamps(truth.stamps, estimate.stamps, max_difference_s)
    true_poses, poses = truth.world_from_camera[rows], estimate.world_from_camera[columns]
    distances_m = _distances_m(true_poses, metrics.by_positions.target_from_source @ poses)
    return PoseErrors(truth.stamps[rows], distances_m, _angles_deg(true_poses, metrics.truth_from_estimate @ poses))


def _distances_m(poses: FloatArray, others: FloatArray) -> FloatArray:
    return np.linalg.norm(others[:, :3, 3] - poses[:, :3, 3], axis=1)


def match_timestamps(
    truth_stamps: FloatArray, estimate_stamps: FloatArray, max_difference_s: float
) -> tuple[Int64Array, Int64Array]:
    """Indices (M,) of true and estimated stamps that match, increasing: the nearest pairs first, each stamp once, at
    most max_difference_s apart; as the TUM benchmark's associate.py."""
    pairs = []
    for row, stamp in enumerate(truth_stamps):
        first, after = np.searchsorted(estimate_stamps, [stamp - max_difference_s, stamp + max_difference_s])
        # One more on either side: the limit itself counts, whatever its rounding.
        candidates = range(max(int(first) - 1, 0), min(int(after) + 1, len(estimate_stamps)))
        pairs += [(abs(float(estimate_stamps[c] - stamp)), row, c) for c in candidates]
    used_rows, used_columns = set(), set()
    chosen = []
    for difference, row, column in sorted(pairs):
        if difference <= max_difference_s + 1e-9 and row not in used_rows and column not in used_columns:
            used_rows.add(row)
            used_columns.add(column)
            chosen.append((row, column))
    ordered = np.array(sorted(chosen), np.int64).reshape(-1, 2)
    return ordered[:, 0], ordered[:, 1]


def _one_second_later(stamps: FloatArray, tolerance_s: float) -> tuple[Int64Array, Int64Array]:
    """Indices (M,) of stamps and of those nearest to one second later, where they differ by a frame at most."""
    spacing = float(np.median(np.diff(stamps))) if len(stamps) > 1 else 0.0
    after = np.searchsorted(stamps, stamps + 1.0).clip(1, max(len(stamps) - 1, 1))
    if len(stamps) < 2:
        return np.zeros(0, np.int64), np.zeros(0, np.int64)
    before_is_nearer = (stamps + 1.0) - stamps[after - 1] <= stamps[after] - (stamps + 1.0)
    later = np.where(before_is_nearer, after - 1, after)
    is_one_second = np.abs(stamps[later] - stamps - 1.0) <= max(spacing / 2, tolerance_s) + 1e-9
    first = np.flatnonzero(is_one_second & (later > np.arange(len(stamps))))
    return first, later[first]


def _relative(true_poses: FloatArray, poses: FloatArray, first: IntArray, second: IntArray) -> RelativeErrors:
    """Errors E = (Q_i^-1 Q_j)^-1 (P_i^-1 P_j) of the steps from i to j."""
    if len(first) == 0:
        return RelativeErrors(float("nan"), float("nan"), 0)
    true_step = np.linalg.inv(true_poses[first]) @ true_poses[second]
    step = np.linalg.inv(poses[first]) @ poses[second]
    error = np.linalg.inv(true_step) @ step
    lengths = np.linalg.norm(error[:, :3, 3], axis=1)
    return RelativeErrors(_root_mean_square(lengths), _root_mean_square(_angles_deg(true_step, step)), len(first))


def _angles_deg(poses: FloatArray, others: FloatArray) -> FloatArray:
    """The angle (N,) between the rotations of two stacks of poses (N, 4, 4), degrees; accurate near 0 as well."""
    relative = poses[:, :3, :3].transpose(0, 2, 1) @ others[:, :3, :3]
    sine = np.stack(
        [
            relative[:, 2, 1] - relative[:, 1, 2],
            relative[:, 0, 2] - relative[:, 2, 0],
            relative[:, 1, 0] - relative[:, 0, 1],
        ],
        axis=1,
    )
    cosine = np.trace(relative, axis1=1, axis2=2) - 1.0
    return np.degrees(np.arctan2(np.linalg.norm(sine, axis=1), cosine))


def _root_mean_square(values: FloatArray) -> float:
    return float(np.sqrt(np.mean(values**2)))
