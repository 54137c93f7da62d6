"""Umeyama alignment of two trajectories of one recording, also where the camera hardly moved."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

import numpy as np

from razer.arrays import Float64Array, FloatArray

AlignmentBasis = Literal["identity", "positions", "orientations"]

_SAME = 1e-5  # poses that differ by less, metres and parts of a rotation matrix, were written to a file and read back
_SPREAD_M = 0.02  # positions that stay nearer to a line than this do not fix the rotation about it
_ORIENTATION_M = 0.01  # how far out an orientation counts beside positions, where these do not fix the rotation


@dataclass(frozen=True, slots=True)
class PoseAlignment:
    """target_from_source (4, 4), and what it is based on: the poses are the same (identity), their positions alone, or,
    as these lie on a line or at one point, their orientations too."""

    target_from_source: Float64Array
    basis: AlignmentBasis


def align_poses(source: FloatArray, target: FloatArray) -> PoseAlignment:
    """The rigid motion that moves source poses (N, 4, 4) nearest to target poses (N, 4, 4), N >= 1.

    Where they are the same but for rounding it is the identity, exactly. It minimises the squared distances of
    positions (Umeyama 1991); where these leave the rotation open, orientations close it."""
    if np.abs(source - target).max() <= _SAME:
        return PoseAlignment(np.eye(4), "identity")
    if min(_spread_m(source[:, :3, 3]), _spread_m(target[:, :3, 3])) >= _SPREAD_M:
        return PoseAlignment(umeyama(source[:, :3, 3], target[:, :3, 3]), "positions")
    turns = target[:, :3, :3] @ source[:, :3, :3].transpose(0, 2, 1)
    return PoseAlignment(
        umeyama(source[:, :3, 3], target[:, :3, 3], _ORIENTATION_M**2 * turns.sum(axis=0)), "orientations"
    )


def umeyama(source: FloatArray, target: FloatArray, prior: FloatArray | float = 0.0) -> Float64Array:
    """The rigid motion (4, 4), without scale, that moves source points (N, 3) nearest to target points (N, 3) in the
    least squares sense (Umeyama 1991, eq. 40-42 with c = 1); prior (3, 3) is added to their covariance, in m^2."""
    mean_source, mean_target = source.mean(axis=0), target.mean(axis=0)
    left, _, right = np.linalg.svd((target - mean_target).T @ (source - mean_source) + prior)
    mirror = np.diag([1.0, 1.0, np.sign(np.linalg.det(left) * np.linalg.det(right))])
    motion = np.eye(4)
    motion[:3, :3] = left @ mirror @ right
    motion[:3, 3] = mean_target - motion[:3, :3] @ mean_source
    return motion


def _spread_m(positions: FloatArray) -> float:
    """How far (N, 3) positions lie from the line nearest to all of them, root mean square along the widest way."""
    if len(positions) < 3:
        return 0.0
    return float(np.linalg.svd(positions - positions.mean(axis=0), compute_uv=False)[1] / np.sqrt(len(positions)))
