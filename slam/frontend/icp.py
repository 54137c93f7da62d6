"""The motion between two views: depth against depth, point to plane, together with matched features.

Both are least squares in the same six unknowns, so their normal equations add up. Where the depth leaves a direction
open, as along a bare corridor, features decide it, and the other way round.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from razer.arrays import Float32Array, Float64Array, FloatArray, IndexArray
from razer.geometry import inverse
from slam.frontend.color_calibration import N_PARAMETERS, ColorCamera
from slam.frontend.correspondences import Correspondences
from slam.frontend.depth_pyramid import SurfaceGrid
from slam.se3 import exp_se3

# Readings of neighbouring pixels err together, and those of one pixel alike from frame to frame, which pulls towards no
# motion at all: thousands of them are worth a share of as many.
DEPTH_BELIEF = 0.2
FACING = 0.8  # least cosine between the normals of points that may be one
TUKEY = 3.0  # residuals beyond this many sigmas are outliers, at the finest level
HUBER = 1.5
MIN_POINTS = 100
# Squared scale of the depth residuals, in those of the sensor at rest: up to the first, nothing but noise is seen and
# depth is not smeared; from the second on it is believed to be.
UNSMEARED, SMEARED = 0.5, 1.0
MEDIAN_SIGMA = 0.6745  # median of absolute values of a normal distribution
SOUND = 0.8  # least agreement of depth for features to tell of the colour camera


@dataclass(frozen=True)
class Level:
    """One level of a registration: how often to iterate at most, how far apart points may be (metres), and whether
    outliers are left out or, as long as it is not clear which ones they are, only weigh less."""

    iterations: int
    reach_m: float
    strict: bool


COARSE = Level(6, 0.15, strict=False)
FINE = Level(8, 0.05, strict=True)


@dataclass(frozen=True)
class IcpResult:
    """Where the source view lies in the target's frame.

    information (6, 6) of a left perturbation of target_from_source (rotation, shift); overlap, the share of the
    source's points that fall on the target's image; agreement, the share of those with a reading there that lie on
    it; fit, the share of all its points there, each counting the less the farther off; rms of the depth residuals in
    sigmas; n_features, inliers among the sightings; camera, with what was learnt.
    """

    target_from_source: Float64Array
    information: Float64Array
    overlap: float
    agreement: float
    fit: float
    rms: float
    n_features: int
    camera: ColorCamera

    @property
    def score(self) -> float:
        """Share of the source's points found on the target."""
        return self.overlap * self.agreement

    @property
    def sigma(self) -> tuple[float, float]:
        """Standard deviations of rotation (radians) and shift (metres) along their least certain axes."""
        covariance = np.linalg.inv(self.information + 1e-9 * np.eye(6))
        rotation, shift = (float(np.linalg.eigvalsh(part)[-1]) for part in (covariance[:3, :3], covariance[3:, 3:]))
        return float(np.sqrt(max(rotation, 0.0))), float(np.sqrt(max(shift, 0.0)))


@dataclass(frozen=True)
class _DepthTerm:
    information: Float64Array
    gradient: Float64Array
    overlap: float
    agreement: float
    fit: float
    rms: float


def icp(
    source: Sequence[SurfaceGrid],
    target: Sequence[SurfaceGrid],
    guess: Float64Array,
    sightings: Correspondences,
    camera: ColorCamera,
    levels: Sequence[Level] = (COARSE, FINE),
    smear: float = 0.0,
) -> IcpResult:
    """Refine the guess of target_from_source by Gauss-Newton, over levels of depth, the coarsest first.

    `smear` is how far off depth may be since the camera turned while it was taken, metres at one metre; it counts where
    depth is found to be off.
    """
    pose, bend = guess.copy(), np.zeros(N_PARAMETERS)
    for number, level in enumerate(levels):
        for _ in range(level.iterations):
            depth = _depth_term(source[number], target[number], pose, level, smear)
            color = sightings.term(pose, camera.parameters + bend)
            information, gradient = _joint(depth, color.information, color.gradient, camera, bend)
            step: Float64Array = np.linalg.solve(information, gradient).astype(np.float64)
            pose = exp_se3(step[:6]) @ pose
            bend = bend + step[6:]
            if np.abs(step[:3]).max() < 1e-4 and np.abs(step[3:6]).max() < 2e-4:
                break
    return _result(pose, bend, depth, color.information, color.n_inliers, camera)


def _joint(
    depth: _DepthTerm, color: Float64Array, color_gradient: Float64Array, camera: ColorCamera, bend: Float64Array
) -> tuple[Float64Array, Float64Array]:
    """Normal equations (13, 13) in pose and colour camera, whose present belief is the prior."""
    information = color.copy()
    information[:6, :6] += DEPTH_BELIEF * depth.information + 1e-6 * np.eye(6)
    information[6:, 6:] += camera.information
    gradient = color_gradient.copy()
    gradient[:6] += DEPTH_BELIEF * depth.gradient
    gradient[6:] -= camera.information @ bend
    return information, gradient


def _result(
    pose: Float64Array, bend: Float64Array, depth: _DepthTerm, color: Float64Array, n_features: int, camera: ColorCamera
) -> IcpResult:
    of_pose = color[:6, :6] + DEPTH_BELIEF * depth.information
    cross, of_camera = color[:6, 6:], color[6:, 6:]
    information = of_pose - cross @ np.linalg.solve(of_camera + camera.information, cross.T)
    # What the features tell of the camera once the motion is accounted for.
    likelihood = of_camera - cross.T @ np.linalg.solve(of_pose + 1e-6 * np.eye(6), cross)
    learnt = camera.learnt(bend, (likelihood + likelihood.T) / 2) if depth.agreement >= SOUND else camera
    information = (information + information.T) / 2
    return IcpResult(pose, information, depth.overlap, depth.agreement, depth.fit, depth.rms, n_features, learnt)


def _depth_term(source: SurfaceGrid, target: SurfaceGrid, pose: Float64Array, level: Level, smear: float) -> _DepthTerm:
    """Normal equations of the point-to-plane distances of points that project onto each other (Blais and Levine 1995;
    Chen and Medioni 1992), each weighted by the sensor's noise at its depth (Nguyen et al. 2012)."""
    points = _moved(source.sample_points, pose)
    inside, pixel = _projected(points, target)
    overlap = len(inside) / max(points.shape[1], 1)
    with_reading = np.flatnonzero(np.take(target.valid, pixel))
    inside, pixel = np.take(inside, with_reading), np.take(pixel, with_reading)
    here, normal = _columns(points, inside), _columns(target.normals, pixel)
    gap = _columns(target.points, pixel) - here
    distance = _dot(gap, normal)
    facing = _dot(pose[:3, :3].astype(np.float32) @ _columns(source.sample_normals, inside), normal)
    near = _dot(gap, gap) < 4 * level.reach_m**2
    good = np.flatnonzero(near & (np.abs(distance) < level.reach_m) & (facing > FACING))
    agreement = len(good) / max(len(inside), 1)
    if len(good) < MIN_POINTS:
        return _DepthTerm(np.zeros((6, 6)), np.zeros(6), overlap, agreement, 0.0, float("inf"))
    here, normal, distance = _columns(here, good), _columns(normal, good), np.take(distance, good)
    scale = np.reciprocal(_sigma(here[2], distance, smear))
    residual = distance * scale
    weight = _weight(residual, level.strict)
    jacobian = np.concatenate([_cross(here, normal), normal]) * scale
    weighted = jacobian * weight
    rms = float(np.sqrt((weight * residual**2).sum() / max(float(weight.sum()), 1e-9)))
    information, gradient = (weighted @ jacobian.T).astype(np.float64), (weighted @ residual).astype(np.float64)
    fit = overlap * float(_weight(residual, strict=True).sum()) / len(inside)
    return _DepthTerm(information, gradient, overlap, agreement, fit, rms)


def _sigma(z: Float32Array, distance: Float32Array, smear: float) -> Float32Array:
    """Deviations of depth at z metres: the sensor's own and, as far as the distances cannot be that, its smear. Where
    a shutter is global nothing is smeared, however fast the camera turns."""
    sigma: Float32Array = depth_sigma(z).astype(np.float32, copy=False)
    if smear == 0:
        return sigma
    scale = float(np.median(np.abs(distance[::4] / sigma[::4]))) / MEDIAN_SIGMA
    doubt = min(max((scale**2 - UNSMEARED) / (SMEARED - UNSMEARED), 0.0), 1.0)
    smeared: Float32Array = np.hypot(sigma, np.float32(doubt * smear) * z)
    return smeared


def _weight(residual: Float32Array, strict: bool) -> Float32Array:
    """Huber's weights, whose single minimum draws from afar, or Tukey's, which leave outliers out."""
    if strict:
        return np.square(1 - np.minimum((residual / TUKEY) ** 2, 1))
    return np.minimum(1, HUBER / np.maximum(np.abs(residual), np.float32(1e-6)))


def depth_sigma(z: FloatArray) -> FloatArray:
    """Axial noise in metres of structured-light depth at z metres (Nguyen, Izadi and Lovell, 3DIMPVT 2012)."""
    return 0.0012 + 0.0019 * (z - 0.4) ** 2


def overlap_of(
    source: SurfaceGrid, target: SurfaceGrid, target_from_source: Float64Array, reach_m: float = 0.3
) -> float:
    """Share of the source's points that project onto readings of the target within reach."""
    points = _moved(source.sample_points, target_from_source)
    inside, pixel = _projected(points, target)
    gap = _columns(target.points, pixel) - _columns(points, inside)
    near = _dot(gap, gap) < reach_m**2
    return float((near & target.valid[pixel]).sum()) / max(points.shape[1], 1)


def mutual_overlap(a: SurfaceGrid, b: SurfaceGrid, a_from_b: Float64Array) -> float:
    """The smaller of the two shares of one view that the other sees."""
    return min(overlap_of(b, a, a_from_b), overlap_of(a, b, inverse(a_from_b)))


def _moved(points: Float32Array, pose: Float64Array) -> Float32Array:
    narrow = pose.astype(np.float32)
    return narrow[:3, :3] @ points + narrow[:3, 3:]


def _projected(points: Float32Array, grid: SurfaceGrid) -> tuple[IndexArray, IndexArray]:
    """Which of the points (3, N) fall on the grid's image, and on which of its pixels."""
    k = grid.intrinsics
    depth = np.where(points[2] > 0.1, points[2], np.float32(np.inf))
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
