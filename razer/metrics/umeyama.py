"""Umeyama alignment of two trajectories of one recording, also where the camera hardly moved.

Two alignments serve two ends. `align_positions` is that of the absolute trajectory error: positions alone, as the
benchmarks define it; where a path leaves its rotation open it says why. `align_views` brings maps together: it goes by
what the cameras saw, so that orientations count beside positions and no path is too straight for it.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

import numpy as np

from razer.arrays import Float64Array, FloatArray

AlignmentBasis = Literal["identity", "positions", "orientations"]

SEEN_AHEAD_M = 2.0  # where a hand-held camera sees surface, about; orientations count by how far they move it
_SAME = 1e-5  # poses that differ by less, metres and parts of a rotation matrix, were written to a file and read back
_SPREAD_M = 0.02  # positions that stay nearer to a line than this do not fix the rotation about it
_ORIENTATION_M = 0.01  # how far out an orientation counts beside positions, where these do not fix the rotation
_OPEN_M = 0.05  # a rotation that moves surface ahead by more than the F-score's limit is not fixed
_STRAIGHT = 0.25  # of a path's length is its width, at most, where it is called straight
_MIN_POSES = 3  # fewer positions lie on a line
# The middle and the corners of an image, on the surface ahead.
_VIEW = SEEN_AHEAD_M * np.array([[0, 0, 1], [-0.5, -0.375, 1], [0.5, -0.375, 1], [-0.5, 0.375, 1], [0.5, 0.375, 1]])
_HUBER = 2.0  # times the median distance: what is farther off pulls no harder
_MAX_ROUNDS, _CONVERGED_M, _FLOOR_M = 100, 1e-10, 1e-9


@dataclass(frozen=True, slots=True)
class PoseAlignment:
    """target_from_source (4, 4), and what it is based on: the poses are the same (identity), their positions alone, or,
    as these lie on a line or at one point, their orientations too. degenerate: why positions do not fix it, in a plain
    clause; None where they do."""

    target_from_source: Float64Array
    basis: AlignmentBasis
    degenerate: str | None = None


def align_positions(source: FloatArray, target: FloatArray) -> PoseAlignment:
    """The rigid motion that moves source poses (N, 4, 4) nearest to target poses (N, 4, 4), N >= 1, by their positions.

    Where they are the same but for rounding it is the identity, exactly. It minimises the squared distances of
    positions (Umeyama 1991); where these leave the rotation open, orientations close it."""
    if are_same(source, target):
        return PoseAlignment(np.eye(4), "identity")
    source_m, target_m = source[:, :3, 3], target[:, :3, 3]
    spreads_m = min(_spreads_m(source_m), _spreads_m(target_m), key=_lever_m)
    if spreads_m[1] >= _SPREAD_M:
        motion = umeyama(source_m, target_m)
        apart_m = _root_mean_square(target_m - source_m @ motion[:3, :3].T - motion[:3, 3])
        return PoseAlignment(motion, "positions", _why_uncertain(spreads_m, apart_m))
    turns = target[:, :3, :3] @ source[:, :3, :3].transpose(0, 2, 1)
    motion = umeyama(source_m, target_m, _ORIENTATION_M**2 * turns.sum(axis=0))
    return PoseAlignment(motion, "orientations", _why_open(len(source), spreads_m))


def align_views(source: FloatArray, target: FloatArray) -> Float64Array:
    """The rigid motion (4, 4) that moves source poses (N, 4, 4) nearest to target poses (N, 4, 4), N >= 1, by what
    their cameras saw: by how far surface `SEEN_AHEAD_M` ahead is displaced.

    The sum of these distances is minimised first, on which a stretch of wrong poses has no more than its share; their
    median is the scale of a Huber loss, which is minimised then (Yohai's MM-estimation 1987). Where the poses are the
    same but for rounding it is the identity, exactly."""
    if are_same(source, target):
        return np.eye(4)
    seen, truly_seen = _views(source), _views(target)
    _, apart_m = _huber_motion(seen, truly_seen, np.ones(len(source)), _FLOOR_M)
    return _huber_motion(seen, truly_seen, apart_m, max(_HUBER * float(np.median(apart_m)), _FLOOR_M))[0]


def _huber_motion(
    seen: Float64Array, truly_seen: Float64Array, apart_m: Float64Array, scale_m: float
) -> tuple[Float64Array, Float64Array]:
    """The motion (4, 4) of views (N, K, 3) onto others of least Huber loss, by iteratively reweighted least squares
    (Weiszfeld 1937), and how far it leaves them apart (N,); from how far apart (N,) they are at the start."""
    motion, least = np.eye(4), np.inf
    for _ in range(_MAX_ROUNDS):
        weights = np.repeat(1 / np.maximum(apart_m, scale_m), seen.shape[1])
        motion = umeyama(seen.reshape(-1, 3), truly_seen.reshape(-1, 3), weights=weights)
        off = truly_seen - seen @ motion[:3, :3].T - motion[:3, 3]
        apart_m = np.sqrt((off**2).sum(axis=2).mean(axis=1))
        loss = float(np.where(apart_m > scale_m, apart_m, (apart_m**2 / scale_m + scale_m) / 2).sum())
        if least - loss <= _CONVERGED_M:
            break
        least = loss
    return motion, apart_m


def are_same(source: FloatArray, target: FloatArray) -> bool:
    """Whether poses (N, 4, 4) differ by no more than what writing them to a file costs."""
    return bool(np.abs(source - target).max() <= _SAME)


def umeyama(
    source: FloatArray, target: FloatArray, prior: FloatArray | float = 0.0, weights: FloatArray | None = None
) -> Float64Array:
    """The rigid motion (4, 4), without scale, that moves source points (N, 3) nearest to target points (N, 3) in the
    least squares sense (Umeyama 1991, eq. 40-42 with c = 1); prior (3, 3) is added to their covariance, in m^2; points
    count by their weights (N,), or all alike."""
    shares = np.full(len(source), 1.0) if weights is None else weights / weights.mean()
    mean_source, mean_target = (np.average(points, axis=0, weights=shares) for points in (source, target))
    scatter = (shares[:, None] * (target - mean_target)).T @ (source - mean_source)
    left, _, right = np.linalg.svd(scatter + prior)
    mirror = np.diag([1.0, 1.0, np.sign(np.linalg.det(left) * np.linalg.det(right))])
    motion = np.eye(4)
    motion[:3, :3] = left @ mirror @ right
    motion[:3, 3] = mean_target - motion[:3, :3] @ mean_source
    return motion


def _views(poses: FloatArray) -> Float64Array:
    """Where the middle and the corners of each image (N, 5, 3) lie, for poses (N, 4, 4)."""
    return _VIEW @ poses[:, :3, :3].transpose(0, 2, 1) + poses[:, None, :3, 3]


def _spreads_m(positions: FloatArray) -> Float64Array:
    """Root mean squares (3,) of (N, 3) positions along their principal axes, the widest first."""
    centred = np.zeros((3, 3)) if len(positions) < 2 else positions - positions.mean(axis=0)
    spreads = np.linalg.svd(centred, compute_uv=False) / np.sqrt(len(positions))
    return np.pad(spreads, (0, 3 - len(spreads)))


def _lever_m(spreads_m: Float64Array) -> float:
    """How far positions lie from the line nearest to all of them, root mean square: what fixes the turn about it."""
    return float(np.hypot(spreads_m[1], spreads_m[2]))


def _why_open(n_poses: int, spreads_m: Float64Array) -> str:
    if n_poses < _MIN_POSES:
        return f"there are too few poses in common ({n_poses})"
    if spreads_m[0] < _SPREAD_M:
        return f"the camera hardly moved (its positions spread by {100 * spreads_m[0]:.1f} cm)"
    return f"the path is straight to within {100 * _lever_m(spreads_m):.1f} cm"


def _why_uncertain(spreads_m: Float64Array, apart_m: float) -> str | None:
    """Why positions `apart_m` from each other, on a path that spreads so, hardly fix the rotation; None if they do.

    Nine in ten simulated paths that drift smoothly turned by less than that distance over the lever."""
    error_rad = float(np.arctan2(apart_m, _lever_m(spreads_m)))
    if SEEN_AHEAD_M * error_rad <= _OPEN_M:
        return None
    wide, broad, high = (100 * float(spread) for spread in spreads_m)
    shape = "short"
    if broad <= _STRAIGHT * wide:
        shape = "nearly straight"
    elif high <= max(_STRAIGHT * broad, 100 * apart_m):
        shape = "nearly flat"
    return (
        f"the path is {shape} (it spreads by {wide:.0f}, {broad:.0f} and {high:.0f} cm), and positions that differ by "
        f"{100 * apart_m:.1f} cm leave the rotation uncertain by up to {np.degrees(error_rad):.0f} degrees"
    )


def _root_mean_square(offsets: FloatArray) -> float:
    return float(np.sqrt((offsets**2).sum(axis=1).mean()))
