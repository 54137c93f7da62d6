"""Feature correspondences between two views: their reprojection errors as a term of ICP, and PnP as a start for it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, fields
from functools import cached_property

import cv2
import numpy as np
from scipy.spatial.transform import Rotation

from razer.arrays import BoolArray, Float64Array, IndexArray
from razer.geometry import inverse
from slam.frontend.color_calibration import (
    BASELINE,
    N_PARAMETERS,
    SCALE,
    ColorCalibration,
    bearing_derivatives,
    readout_flow,
)
from slam.frontend.features import Features

INLIER_SIGMAS = 3.0  # of the deviations of a feature; 99 in 100 true correspondences are within
MIN_INLIERS = 12  # twice the unknowns: fewer agree by chance
FARTHEST_M = 100.0  # apart, of views of one place; points all but on a line put the camera anywhere
MIN_DEPTH_M = 0.05  # nearer points, and those behind the camera, are not projected


@dataclass(frozen=True)
class ColorTerm:
    """Normal equations of features in pose and colour camera: information (13, 13), gradient (13,), inliers."""

    information: Float64Array
    gradient: Float64Array
    n_inliers: int


@dataclass(frozen=True)
class Correspondences:
    """M points: target_rays (M, 2) nominal and target_depth_m (M,) where the target saw them, source_rays (M, 2) where
    the source did, sigma (M,) of a ray, and how the rays move, target_flow and source_flow (M, 2), per second of
    readout as the cameras turn."""

    target_rays: Float64Array
    target_depth_m: Float64Array
    source_rays: Float64Array
    sigma: Float64Array
    target_flow: Float64Array
    source_flow: Float64Array

    @classmethod
    def of(
        cls,
        target: Features,
        source: Features,
        pairs: IndexArray,
        target_turning: Float64Array,
        source_turning: Float64Array,
    ) -> Correspondences:
        """Correspondences from matched features.

        Args:
            target: features of the view with depth.
            source: features of the view that is brought to it.
            pairs: (M, 2) indices of matched (target, source) features.
            target_turning: (3,) rad/s about the target camera's own axes.
            source_turning: (3,) rad/s about the source camera's own axes.
        """
        t, s = pairs.T
        target_rays, source_rays = target.rays[t].astype(np.float64), source.rays[s].astype(np.float64)
        return cls(
            target_rays,
            target.depth_m[t].astype(np.float64),
            source_rays,
            np.maximum(target.sigma[t], source.sigma[s]).astype(np.float64),
            readout_flow(target_rays, target.row_times[t], target_turning),
            readout_flow(source_rays, source.row_times[s], source_turning),
        )

    @classmethod
    def at_rest(
        cls, target_rays: Float64Array, target_depth_m: Float64Array, source_rays: Float64Array, sigma: Float64Array
    ) -> Correspondences:
        """Correspondences of cameras that do not turn.

        Args:
            target_rays: (M, 2) nominal rays of the target.
            target_depth_m: (M,) metres, where the target has them.
            source_rays: (M, 2) nominal rays of the source.
            sigma: (M,) standard deviations of a ray.
        """
        still = np.zeros((len(sigma), 2))
        return cls(target_rays, target_depth_m, source_rays, sigma, still, still)

    @classmethod
    def none(cls) -> Correspondences:
        """No correspondences at all."""
        return cls.at_rest(np.zeros((0, 2)), np.zeros(0), np.zeros((0, 2)), np.zeros(0))

    @classmethod
    def joined(cls, parts: Sequence[Correspondences]) -> Correspondences:
        """Those of all parts."""
        return cls(*(np.concatenate([getattr(part, field.name) for part in parts]) for field in fields(cls)))

    def __len__(self) -> int:
        return len(self.sigma)

    def select(self, keep: BoolArray | IndexArray) -> Correspondences:
        """Those at the given indices, or where a boolean is true."""
        return Correspondences(*(getattr(self, part.name)[keep] for part in fields(self)))

    @cached_property
    def _target_derivatives(self) -> Float64Array:
        return _components_first(bearing_derivatives(self.target_rays, self.target_flow))

    @cached_property
    def _source_derivatives(self) -> Float64Array:
        return _components_first(bearing_derivatives(self.source_rays, self.source_flow))

    def points(self, parameters: Float64Array) -> Float64Array:
        """The points (M, 3) in the target's depth camera."""
        x, y = _weighted(self._target_derivatives, parameters)
        points = np.column_stack([x, y, np.ones(len(self))]) * self.target_depth_m[:, None]
        points[:, 0] -= parameters[BASELINE]
        return points

    def source_bearings(self, parameters: Float64Array) -> Float64Array:
        """Where the source's colour camera saw them (M, 2)."""
        return _weighted(self._source_derivatives, parameters).T

    def residuals(self, target_from_source: Float64Array, parameters: Float64Array) -> Float64Array:
        """Predicted minus observed rays (M, 2) of the source's colour camera, in sigmas; inf behind it.

        Bearings are divided by the camera's scale, as rays are what was measured: else a camera that shrinks the
        whole world would shrink its errors, too.
        """
        return self._errors(_in_source(self.points(parameters), target_from_source, parameters), parameters)

    def _errors(self, predicted: Float64Array, parameters: Float64Array) -> Float64Array:
        """Residuals (M, 2) of points (M, 3) before the source's colour camera."""
        depth = np.where(predicted[:, 2:] > MIN_DEPTH_M, predicted[:, 2:], np.nan)
        error = predicted[:, :2] / depth - self.source_bearings(parameters)
        return np.nan_to_num(error / (parameters[SCALE] * self.sigma[:, None]), nan=np.inf)

    def inliers(
        self, target_from_source: Float64Array, parameters: Float64Array, sigmas: float = INLIER_SIGMAS
    ) -> BoolArray:
        """Which correspondences (M,) bool the motion explains."""
        return (self.residuals(target_from_source, parameters) ** 2).sum(axis=1) < sigmas**2

    def term(self, target_from_source: Float64Array, parameters: Float64Array) -> ColorTerm:
        """Normal equations about the given motion and colour camera, with Cauchy weights."""
        if len(self) == 0:
            return ColorTerm(np.zeros((6 + N_PARAMETERS, 6 + N_PARAMETERS)), np.zeros(6 + N_PARAMETERS), 0)
        points = self.points(parameters)
        predicted = _in_source(points, target_from_source, parameters)
        residual = self._errors(predicted, parameters)
        in_front = np.asarray(np.isfinite(residual).all(axis=1))
        if not in_front.all():
            return self.select(in_front).term(target_from_source, parameters)
        jacobian = self._jacobian(points, predicted, target_from_source[:3, :3])
        jacobian /= parameters[SCALE] * self.sigma
        jacobian[6 + SCALE] -= residual.T / parameters[SCALE]
        squared = (residual**2).sum(axis=1)
        flat = jacobian.reshape(len(jacobian), -1)
        weighted = (jacobian / (1 + squared / 4)).reshape(flat.shape)
        gradient = -weighted @ residual.T.ravel()
        return ColorTerm(weighted @ flat.T, gradient, int((squared < INLIER_SIGMAS**2).sum()))

    def _jacobian(self, points: Float64Array, predicted: Float64Array, rotation: Float64Array) -> Float64Array:
        """Derivatives (13, 2, M) of the bearing errors by a left perturbation of the motion, whose rotation is (3, 3),
        and by the camera; of points (M, 3) before the target's depth camera and before the source's colour camera."""
        result = np.empty((6 + N_PARAMETERS, 2, len(self)))
        inverse_depth = 1 / predicted[:, 2]
        right, down, ahead = rotation.T
        by_point, by_camera = result[3:6], result[6:]
        by_point[:, 0] = right[:, None] - ahead[:, None] * (predicted[:, 0] * inverse_depth)
        by_point[:, 1] = down[:, None] - ahead[:, None] * (predicted[:, 1] * inverse_depth)
        by_point *= inverse_depth
        (x, y, z), (a, b, c) = points.T, by_point
        result[0], result[1], result[2] = z * b - y * c, x * c - z * a, y * a - x * b
        by_ray, derivatives = self.target_depth_m * by_point[:2], self._target_derivatives
        by_camera[:] = by_ray[0] * derivatives[:, :1] + by_ray[1] * derivatives[:, 1:] - self._source_derivatives
        by_camera[BASELINE] = -a
        by_camera[BASELINE, 0] += inverse_depth
        np.negative(by_point, out=by_point)
        return result


def _in_source(points: Float64Array, target_from_source: Float64Array, parameters: Float64Array) -> Float64Array:
    """Points (M, 3) of the target's depth camera before the source's colour camera."""
    source_from_target = inverse(target_from_source)
    predicted = points @ source_from_target[:3, :3].T + source_from_target[:3, 3]
    predicted[:, 0] += parameters[BASELINE]
    return predicted


def _components_first(derivatives: Float64Array) -> Float64Array:
    """Derivatives (M, 2, 7) as (7, 2, M): to work on all points at once takes half the time."""
    return np.ascontiguousarray(derivatives.T)


def _weighted(derivatives: Float64Array, parameters: Float64Array) -> Float64Array:
    """The sum (2, M) of derivatives (7, 2, M), each times its parameter."""
    result: Float64Array = (parameters @ derivatives.reshape(len(parameters), -1)).reshape(2, -1)
    return result


def solve_pnp(correspondences: Correspondences, calibration: ColorCalibration, tries: int) -> Float64Array | None:
    """target_from_source by PnP with RANSAC over at most so many minimal sets; None where too few agree, or it is
    nowhere."""
    if len(correspondences) < MIN_INLIERS:
        return None
    points = correspondences.points(calibration.parameters)
    bearings = correspondences.source_bearings(calibration.parameters)
    solved, turn, shift, inliers = cv2.solvePnPRansac(
        points, bearings, np.eye(3), None, iterationsCount=tries, confidence=0.999,
        reprojectionError=INLIER_SIGMAS * float(np.median(correspondences.sigma)), flags=cv2.SOLVEPNP_AP3P,
    )  # fmt: skip
    if not solved or inliers is None or len(inliers) < MIN_INLIERS or not np.abs(shift).max() <= FARTHEST_M:
        return None
    source_from_target = np.eye(4)
    source_from_target[:3, :3] = Rotation.from_rotvec(turn.ravel()).as_matrix()
    source_from_target[:3, 3] = shift.ravel()
    return inverse(source_from_target)
