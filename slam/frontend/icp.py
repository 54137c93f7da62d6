"""ICP: point-to-plane with projective association, together with the reprojection errors of matched features.

Both are least squares in the same six unknowns, so their normal equations add up. Where the depth leaves a direction
open, as along a bare corridor, features decide it, and the other way round.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from razer.arrays import Float64Array
from slam.frontend.color_calibration import N_PARAMETERS, ColorCalibration
from slam.frontend.depth_noise import DepthNoise
from slam.frontend.depth_pyramid import SurfaceGrid
from slam.frontend.gauss_newton.anderson_acceleration import AndersonAcceleration
from slam.frontend.gauss_newton.correspondences import ColorTerm, Correspondences
from slam.frontend.gauss_newton.depth_term import DepthTerm
from slam.se3 import exp_se3, orthonormal

# Readings of neighbouring pixels err together, and those of one pixel alike from frame to frame, which pulls towards no
# motion at all: thousands of them count as this share of as many.
DEPTH_SHARE = 0.2
MIN_CALIBRATION_AGREEMENT = 0.8  # of depth, for its motion to be known well enough to learn the colour camera from
LEAST_INFORMATION = 1e-3  # along any axis, 1 / rad^2 and 1 / m^2: nothing is known
FARTHEST_STEP = 100.0  # radians and metres: equations that ask for more say nothing, and the next would overflow


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
    its sigmas the equations still changed the motion at last: one that had not come to rest was not measured.
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


def icp(
    source: Sequence[SurfaceGrid],
    target: Sequence[SurfaceGrid],
    guess: Float64Array,
    correspondences: Correspondences,
    calibration: ColorCalibration,
    noise: DepthNoise,
    levels: Sequence[Level] = (COARSE, FINE),
) -> IcpResult:
    """Refine the guess of target_from_source by accelerated Gauss-Newton, over levels of depth, the coarsest first.

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
        acceleration = AndersonAcceleration()
        for _ in range(level.iterations):
            depth = DepthTerm.of(source[number], target[number], pose, noise, level.reach_m, level.strict)
            color = correspondences.term(pose, calibration.parameters + calibration_step)
            information, gradient = _joint(depth, color, calibration, calibration_step)
            step: Float64Array = np.linalg.solve(information, gradient).astype(np.float64)
            if np.abs(step[:6]).max() > FARTHEST_STEP:
                break  # last_step tells
            at_rest = np.abs(step[:3]).max() < level.min_step_rad and np.abs(step[3:6]).max() < level.min_step_m
            taken = step if at_rest else acceleration.accelerated(step, information)
            pose = exp_se3(taken[:6]) @ pose
            calibration_step = calibration_step + taken[6:]
            if at_rest:
                break
    # Rounding is removed, since the next frame's guess is made of powers of this motion: it would grow by 1 + sqrt(2)
    # with each frame, until rotations shrink what they turn.
    result = _result(orthonormal(pose), depth, color, calibration, calibration_step)
    return replace(result, last_step=float(np.sqrt(step[:6] @ result.information @ step[:6])))


def _joint(
    depth: DepthTerm, color: ColorTerm, calibration: ColorCalibration, calibration_step: Float64Array
) -> tuple[Float64Array, Float64Array]:
    """Normal equations (13, 13) in pose and colour camera, whose calibration so far is the prior."""
    information = color.information.copy()
    of_depth, gradient_of_depth = depth.equations
    information[:6, :6] += DEPTH_SHARE * of_depth + 1e-6 * np.eye(6)
    information[6:, 6:] += calibration.information
    gradient = color.gradient.copy()
    gradient[:6] += DEPTH_SHARE * gradient_of_depth
    gradient[6:] -= calibration.information @ calibration_step
    return information, gradient


def _result(
    pose: Float64Array, depth: DepthTerm, color: ColorTerm, calibration: ColorCalibration, step: Float64Array
) -> IcpResult:
    cross, of_camera = color.information[:6, 6:], color.information[6:, 6:]
    solved = color.information[:6, :6] + DEPTH_SHARE * depth.equations[0]
    # The noise of one view's normals is not that of the other's: what both have in common is shape.
    known = color.information[:6, :6] + DEPTH_SHARE * _bounded(depth.shape_information, 0.0)
    of_both = cross @ np.linalg.solve(of_camera + calibration.information, cross.T)
    known_of_pose, solved_of_pose = (_bounded(each - of_both, LEAST_INFORMATION) for each in (known, solved))
    # What the features know of the camera once the motion is accounted for.
    likelihood = of_camera - cross.T @ np.linalg.solve(solved + 1e-6 * np.eye(6), cross)
    if depth.is_enough and depth.agreement >= MIN_CALIBRATION_AGREEMENT:
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
