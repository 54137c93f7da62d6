"""ICP: point-to-plane with projective association, together with the reprojection errors of matched features.

Both are least squares in the same six unknowns, so their normal equations add up. Where the depth leaves a direction
open, as along a bare corridor, features decide it, and the other way round.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from razer.arrays import Float32Array, Float64Array, IndexArray
from slam.frontend.color_calibration import N_PARAMETERS, ColorCalibration
from slam.frontend.correspondences import ColorTerm, Correspondences
from slam.frontend.depth_noise import DepthNoise
from slam.frontend.depth_pyramid import SurfaceGrid
from slam.se3 import exp_se3, orthonormal

# Readings of neighbouring pixels err together, and those of one pixel alike from frame to frame, which pulls towards no
# motion at all: thousands of them count as this share of as many.
DEPTH_SHARE = 0.2
MIN_NORMAL_COSINE = 0.8  # between the normals of points that may be one; noise alone turns normals by half as much
TUKEY = 3.0  # residuals beyond this many sigmas are outliers, at the finest level
HUBER = 1.5  # from so many sigmas on residuals weigh less, at the coarse level: 95 % efficient under normal noise
MIN_POINTS = 100  # with fewer there is no depth term: six unknowns from noisy readings at a coarse grid
MIN_CALIBRATION_AGREEMENT = 0.8  # of depth, for its motion to be known well enough to learn the colour camera from
LEAST_INFORMATION = 1e-3  # along any axis, 1 / rad^2 and 1 / m^2: nothing is known
FARTHEST_STEP = 100.0  # radians and metres: equations that ask for more say nothing, and the next would overflow
# Normals of n points of a bare wall, under noise of their own in each view, have up to this / sqrt(n) of their spread
# in common by chance: in 95 of 100 pairs of simulated views, along that of the three open axes that has most.
CHANCE = 4.5
MIN_DEPTH_M = 0.1  # nearer points, and those behind the camera, are not projected


@dataclass(frozen=True)
class Level:
    """One level of the pyramid: how often to iterate at most, how far apart points may be (metres), whether outliers
    are left out or, as long as it is not clear which ones they are, only weigh less, and below which steps (radians and
    metres) Gauss-Newton has converged."""

    iterations: int
    reach_m: float
    strict: bool
    min_step_rad: float
    min_step_m: float


COARSE = Level(6, 0.15, strict=False, min_step_rad=5e-4, min_step_m=1e-3)  # a third of what tells starts apart
FINE = Level(8, 0.05, strict=True, min_step_rad=1e-4, min_step_m=2e-4)  # far below what a pixel resolves


@dataclass(frozen=True)
class IcpResult:
    """Where the source view lies in the target's frame.

    information (6, 6) of a left perturbation of target_from_source (rotation, shift); solved_information, that of the
    equations it was solved by, in which the noise of normals counts as if it were shape; overlap, the share of the
    source's points that fall on the target's image; agreement, the share of those with a reading that lie on
    it; fit, the share of all its points on it, each counting the less the farther off; rms of the depth residuals in
    sigmas; n_features, inliers among the correspondences; calibration, with what was learnt; last_step, by how many of
    its sigmas the motion still changed at last: one that had not come to rest was not measured.
    """

    target_from_source: Float64Array
    information: Float64Array
    solved_information: Float64Array
    overlap: float
    agreement: float
    fit: float
    rms: float
    n_features: int
    calibration: ColorCalibration
    last_step: float = 0.0

    @property
    def score(self) -> float:
        """Share of the source's points that lie on the target's surface."""
        return self.overlap * self.agreement

    @property
    def sigma(self) -> tuple[float, float]:
        """Standard deviations of rotation (radians) and shift (metres) along their least certain axes."""
        return _sigma(self.information)

    @property
    def solved_sigma(self) -> tuple[float, float]:
        """The same by solved_information: large where there is neither shape nor noise."""
        return _sigma(self.solved_information)


@dataclass(frozen=True)
class _DepthTerm:
    information: Float64Array
    gradient: Float64Array
    shape_information: Float64Array
    overlap: float
    agreement: float
    fit: float
    rms: float


def icp(
    source: Sequence[SurfaceGrid],
    target: Sequence[SurfaceGrid],
    guess: Float64Array,
    correspondences: Correspondences,
    calibration: ColorCalibration,
    noise: DepthNoise,
    levels: Sequence[Level] = (COARSE, FINE),
) -> IcpResult:
    """Refine the guess of target_from_source by Gauss-Newton, over levels of depth, the coarsest first.

    Args:
        source: grids of the view that is moved, one for each level.
        target: grids of the view it is brought to, one for each level.
        guess: target_from_source (4, 4) to start from.
        correspondences: matched features of the two views, for all levels.
        calibration: the colour camera as known so far.
        noise: of the depth of both views.
        levels: how each level is iterated.
    """
    pose, calibration_step = guess.copy(), np.zeros(N_PARAMETERS)
    for number, level in enumerate(levels):
        for _ in range(level.iterations):
            depth = _depth_term(source[number], target[number], pose, level, noise)
            color = correspondences.term(pose, calibration.parameters + calibration_step)
            information, gradient = _joint(depth, color, calibration, calibration_step)
            step: Float64Array = np.linalg.solve(information, gradient).astype(np.float64)
            if np.abs(step[:6]).max() > FARTHEST_STEP:
                break  # last_step tells
            pose = exp_se3(step[:6]) @ pose
            calibration_step = calibration_step + step[6:]
            if np.abs(step[:3]).max() < level.min_step_rad and np.abs(step[3:6]).max() < level.min_step_m:
                break
    # Rounding is removed, since the next frame's guess is made of powers of this motion: it would grow by 1 + sqrt(2)
    # with each frame, until rotations shrink what they turn.
    result = _result(orthonormal(pose), depth, color, calibration, calibration_step)
    return replace(result, last_step=float(np.sqrt(step[:6] @ result.information @ step[:6])))


def _joint(
    depth: _DepthTerm, color: ColorTerm, calibration: ColorCalibration, calibration_step: Float64Array
) -> tuple[Float64Array, Float64Array]:
    """Normal equations (13, 13) in pose and colour camera, whose calibration so far is the prior."""
    information = color.information.copy()
    information[:6, :6] += DEPTH_SHARE * depth.information + 1e-6 * np.eye(6)
    information[6:, 6:] += calibration.information
    gradient = color.gradient.copy()
    gradient[:6] += DEPTH_SHARE * depth.gradient
    gradient[6:] -= calibration.information @ calibration_step
    return information, gradient


def _result(
    pose: Float64Array, depth: _DepthTerm, color: ColorTerm, calibration: ColorCalibration, step: Float64Array
) -> IcpResult:
    cross, of_camera = color.information[:6, 6:], color.information[6:, 6:]
    solved = color.information[:6, :6] + DEPTH_SHARE * depth.information
    # The noise of one view's normals is not that of the other's: what both have in common is shape.
    known = color.information[:6, :6] + DEPTH_SHARE * _bounded(depth.shape_information, 0.0)
    of_both = cross @ np.linalg.solve(of_camera + calibration.information, cross.T)
    known_of_pose, solved_of_pose = (_bounded(each - of_both, LEAST_INFORMATION) for each in (known, solved))
    # What the features know of the camera once the motion is accounted for.
    likelihood = of_camera - cross.T @ np.linalg.solve(solved + 1e-6 * np.eye(6), cross)
    if depth.agreement >= MIN_CALIBRATION_AGREEMENT:
        calibration = calibration.updated(step, (likelihood + likelihood.T) / 2)
    figures = depth.overlap, depth.agreement, depth.fit, depth.rms, color.n_inliers
    return IcpResult(pose, known_of_pose, solved_of_pose, *figures, calibration)


def _sigma(information: Float64Array) -> tuple[float, float]:
    covariance = np.linalg.inv(information)
    rotation, shift = (float(np.linalg.eigvalsh(part)[-1]) for part in (covariance[:3, :3], covariance[3:, 3:]))
    return float(np.sqrt(max(rotation, 0.0))), float(np.sqrt(max(shift, 0.0)))


def _bounded(matrix: Float64Array, least: float) -> Float64Array:
    """The nearest matrix that is symmetric and has no smaller eigenvalues."""
    values, axes = np.linalg.eigh((matrix + matrix.T) / 2)
    nearest: Float64Array = axes * values.clip(least) @ axes.T
    return nearest


def _depth_term(
    source: SurfaceGrid, target: SurfaceGrid, pose: Float64Array, level: Level, noise: DepthNoise
) -> _DepthTerm:
    """Normal equations of the point-to-plane distances of points that project onto each other (Blais and Levine 1995;
    Chen and Medioni 1992), each weighted by the sensor's noise at its depth."""
    points = _moved(source.sample_points, pose)
    inside, pixel = _projected(points, target)
    overlap = len(inside) / max(points.shape[1], 1)
    with_reading = np.flatnonzero(np.take(target.valid, pixel))
    inside, pixel = np.take(inside, with_reading), np.take(pixel, with_reading)
    moved, normal = _columns(points, inside), _columns(target.normals, pixel)
    gap = _columns(target.points, pixel) - moved
    distance = _dot(gap, normal)
    own_normal = pose[:3, :3].astype(np.float32) @ _columns(source.sample_normals, inside)
    facing = _dot(own_normal, normal)
    near = _dot(gap, gap) < 4 * level.reach_m**2
    matched = np.flatnonzero(near & (np.abs(distance) < level.reach_m) & (facing > MIN_NORMAL_COSINE))
    agreement = len(matched) / max(len(inside), 1)
    if len(matched) < MIN_POINTS:
        nothing = np.zeros((6, 6))
        return _DepthTerm(nothing, np.zeros(6), nothing, overlap, agreement, 0.0, float("inf"))
    moved, normal, distance = _columns(moved, matched), _columns(normal, matched), np.take(distance, matched)
    scale = np.reciprocal(noise.sigma(moved[2], distance))
    residual = distance * scale
    weight = _weight(residual, level.strict)
    jacobian = _jacobian(moved, normal) * scale
    weighted = jacobian * weight
    rms = float(np.sqrt((weight * residual**2).sum() / max(float(weight.sum()), 1e-9)))
    information, gradient = (weighted @ jacobian.T).astype(np.float64), (weighted @ residual).astype(np.float64)
    fit = overlap * float(_weight(residual, strict=True).sum()) / len(inside)
    shape = information
    if level.strict:
        in_common = (weighted @ (_jacobian(moved, _columns(own_normal, matched)) * scale).T).astype(np.float64)
        shape = in_common - CHANCE / np.sqrt(len(matched)) * (information - in_common)
    return _DepthTerm(information, gradient, shape, overlap, agreement, fit, rms)


def _jacobian(points: Float32Array, normals: Float32Array) -> Float32Array:
    """Of the distances of points (3, N) to planes with the given normals, by a left perturbation (6, N)."""
    return np.concatenate([_cross(points, normals), normals])


def _weight(residual: Float32Array, strict: bool) -> Float32Array:
    """Huber's weights, whose single minimum draws from afar, or Tukey's, which leave outliers out."""
    if strict:
        return np.square(1 - np.minimum((residual / TUKEY) ** 2, 1))
    return np.minimum(1, HUBER / np.maximum(np.abs(residual), np.float32(1e-6)))


def _moved(points: Float32Array, pose: Float64Array) -> Float32Array:
    narrow = pose.astype(np.float32)
    return narrow[:3, :3] @ points + narrow[:3, 3:]


def _projected(points: Float32Array, grid: SurfaceGrid) -> tuple[IndexArray, IndexArray]:
    """Which of the points (3, N) fall on the grid's image, and on which of its pixels."""
    k = grid.intrinsics
    depth = np.where(points[2] > MIN_DEPTH_M, points[2], np.float32(np.inf))
    u = np.rint(points[0] / depth * np.float32(k.fx) + np.float32(k.cx))
    v = np.rint(points[1] / depth * np.float32(k.fy) + np.float32(k.cy))
    inside = np.flatnonzero((u >= 0) & (v >= 0) & (u < k.width) & (v < k.height) & np.isfinite(depth))
    return inside, (v[inside] * k.width + u[inside]).astype(np.intp)


def _columns(a: Float32Array, which: IndexArray) -> Float32Array:
    """a[:, which], several times faster."""
    return np.take(a, which, axis=1)


def _dot(a: Float32Array, b: Float32Array) -> Float32Array:
    """The product (N,) of each column of a (3, N) with that of b."""
    product: Float32Array = a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
    return product


def _cross(a: Float32Array, b: Float32Array) -> Float32Array:
    return np.stack([a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]])
