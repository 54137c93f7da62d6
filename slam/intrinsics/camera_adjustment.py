"""Adjustment of one pinhole camera and the motions of many pairs of views: least squares over what both views saw.

With a wrong focal length the world is stretched across the line of sight and not along it. What two views saw from the
same direction can still be laid upon each other; once the camera has turned it cannot, as what was stretched in the one
is not in the other. So pairs of views that turned tell the camera, and views that only moved forward tell nothing.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np

from razer.arrays import Float64Array, Int64Array
from razer.frame import Intrinsics
from slam.frontend.depth_noise import MEDIAN_SIGMA, DepthNoise
from slam.intrinsics.matched_views import ViewMatches, back_projected, rigid_start
from slam.se3 import exp_se3

FACTORS = 1.09 ** np.arange(-6, 7)  # of the guessed focal length, to start from: 0.6 to 1.68
N_TRIED = 40  # pairs of views, or up to twice as many, that choose among them
MIN_MATCHES = 20  # of a pair that are explained; more than three times its unknowns
MIN_EXPLAINED = 0.3  # share of a pair's matches
ITERATIONS, ROUNDS = 8, 4  # of Gauss-Newton, and of learning how far pixels and depth err
SETTLED = 1e-5  # share of the focal length by which the last step moved it
MIN_SCALE = 0.02  # of the errors of pixels and depth: none are exact
# Prior: the focal length may be anything, pixels are square as far as the guess says, as those of all depth cameras
# are, and the principal point lies within a few percent of the width where it is guessed.
PRIOR_FOCAL, PRIOR_ASPECT, PRIOR_CENTRE = 0.5, 0.002, 0.02


@dataclass(frozen=True)
class ViewPair:
    """Matches of two views, and the stretch of the recording that they are of: pairs of one err together."""

    matches: ViewMatches
    group: int


class _Linear(NamedTuple):
    """Whitened residuals (M, 3) of all matches, and their derivatives (M, 3, 10) by the motion of their pair, in front,
    and the camera."""

    residual: Float64Array
    jacobian: Float64Array


class _Normal(NamedTuple):
    """Normal equations of the camera with the motions eliminated: information (4, 4), what each pair wants (P, 4), and
    what it takes to have the motions: information (P, 6, 6), gradients (P, 6) and cross terms (P, 6, 4)."""

    information: Float64Array
    gradients: Float64Array
    of_motion: Float64Array
    motion_gradients: Float64Array
    cross: Float64Array


@dataclass(frozen=True)
class CameraAdjustment:
    """A camera (4,) fx, fy, cx, cy, and motions second_from_first (P, 4, 4) of pairs, adjusted together to their
    matches; `starts` (P,), where those of each begin, `pair` (M,), the pair of each, and `groups` (P,). px_scale and
    depth_scale: how much more pixels and depth err than was taken for granted; aspect: the prior of square pixels."""

    guess: Float64Array
    width: int
    noise: DepthNoise
    matches: ViewMatches
    starts: Int64Array
    pair: Int64Array
    groups: Int64Array
    camera: Float64Array
    motions: Float64Array
    px_scale: float = 1.0
    depth_scale: float = 1.0
    aspect: float = PRIOR_ASPECT

    @classmethod
    def begun(cls, pairs: Sequence[ViewPair], guess: Intrinsics, noise: DepthNoise) -> CameraAdjustment | None:
        """To begin with: the focal length under which rigid motions explain most; None where none does."""
        some = pairs[:: max(1, len(pairs) // N_TRIED)]
        guessed = np.array([guess.fx, guess.fy, guess.cx, guess.cy])
        cameras = [guessed * (factor, factor, 1.0, 1.0) for factor in FACTORS.tolist()]
        costs = [sum(rigid_start(pair.matches, camera, noise).cost for pair in some) for camera in cameras]
        camera = cameras[int(np.argmin(costs))]
        starts = [(pair, rigid_start(pair.matches, camera, noise)) for pair in pairs]
        kept = [
            (pair, start.second_from_first)
            for pair, start in starts
            if start.explained.sum() >= max(MIN_MATCHES, MIN_EXPLAINED * len(pair.matches))
        ]
        if not kept:
            return None
        sizes = np.array([len(pair.matches) for pair, _ in kept])
        return cls(
            guessed,
            guess.width,
            noise,
            ViewMatches.joined([pair.matches for pair, _ in kept]),
            np.concatenate([[0], np.cumsum(sizes)[:-1]]),
            np.repeat(np.arange(len(kept)), sizes),
            np.array([pair.group for pair, _ in kept]),
            camera,
            np.stack([motion for _, motion in kept]),
        )

    def solved(self) -> CameraAdjustment:
        """The same after Gauss-Newton with Geman-McClure's weights, which leave outliers out, and with the errors of
        pixels and of depth as they are found to be: sensors differ, and the one must not outvote the other."""
        solved = self
        for _ in range(ROUNDS):
            solved = solved.descended()._rescaled()
        return solved.descended()

    def descended(self) -> CameraAdjustment:
        """The same at the nearest minimum."""
        current = self
        for _ in range(ITERATIONS):
            before, current = current.camera, current._stepped()
            if abs(current.camera[0] / before[0] - 1) < SETTLED:
                break
        return current

    def _stepped(self) -> CameraAdjustment:
        normal, (information, pull) = self._normal(self._linear()), self._prior()
        step = np.linalg.solve(normal.information + information, normal.gradients.sum(axis=0) + pull)
        rest = normal.motion_gradients - normal.cross @ step
        turns = np.linalg.solve(normal.of_motion, rest[:, :, None])[:, :, 0]
        motions = [exp_se3(turn) @ old for turn, old in zip(turns, self.motions, strict=True)]
        return replace(self, camera=self.camera + step, motions=np.stack(motions))

    def _rescaled(self) -> CameraAdjustment:
        x, y, z = np.median(np.abs(self._linear().residual), axis=0) / MEDIAN_SIGMA
        px_scale, depth_scale = self.px_scale * float(np.hypot(x, y)) / np.sqrt(2), self.depth_scale * float(z)
        return replace(self, px_scale=max(px_scale, MIN_SCALE), depth_scale=max(depth_scale, MIN_SCALE))

    def sigma_px(self) -> Float64Array:
        """Standard deviations (4,) of the camera: by the spread of what stretches of the recording want, as errors of
        one stretch go together, and no less than noise alone leaves (Liang and Zeger, Biometrika 1986)."""
        linear = self._linear()
        normal = self._normal(linear)
        prior, _ = self._prior()
        covariance = np.linalg.inv(normal.information + prior)
        groups = np.unique(self.groups)
        wanted = np.stack([normal.gradients[self.groups == group].sum(axis=0) for group in groups])
        wanted -= wanted.mean(axis=0)
        spread = wanted.T @ wanted * len(groups) / (len(groups) - 1) + prior
        by_spread = covariance @ spread @ covariance
        sigma: Float64Array = np.sqrt(np.maximum(np.diag(by_spread), np.diag(covariance)))
        return sigma

    def _prior(self) -> tuple[Float64Array, Float64Array]:
        """Information (4, 4) about the camera that the guess brings, and its pull (4,) from here."""
        fx, fy = self.guess[:2]
        rows = np.array(
            [
                [0.5 / fx / PRIOR_FOCAL, 0.5 / fy / PRIOR_FOCAL, 0, 0],
                [1 / fx / self.aspect, -1 / fy / self.aspect, 0, 0],
                [0, 0, 1 / (PRIOR_CENTRE * self.width), 0],
                [0, 0, 0, 1 / (PRIOR_CENTRE * self.width)],
            ]
        )
        information = rows.T @ rows
        return information, information @ (self.guess - self.camera)

    def _normal(self, linear: _Linear) -> _Normal:
        squared = (linear.residual**2).sum(axis=1)
        weight = 1 / (1 + squared / 9) ** 2
        weighted = linear.jacobian * weight[:, None, None]
        information = np.add.reduceat(np.einsum("mij,mik->mjk", weighted, linear.jacobian), self.starts)
        gradient = -np.add.reduceat(np.einsum("mij,mi->mj", weighted, linear.residual), self.starts)
        of_motion = information[:, :6, :6] + 1e-6 * np.eye(6)
        cross = information[:, :6, 6:]
        share = np.linalg.solve(of_motion, cross).transpose(0, 2, 1)
        of_camera = (information[:, 6:, 6:] - share @ cross).sum(axis=0)
        gradients = gradient[:, 6:] - (share @ gradient[:, :6, None])[:, :, 0]
        return _Normal(of_camera, gradients, of_motion, gradient[:, :6], cross)

    def _linear(self) -> _Linear:
        """Where and how far the second view saw what the first one saw, predicted minus measured."""
        matches, (fx, fy, cx, cy) = self.matches, self.camera
        rotation, shift = self.motions[self.pair, :3, :3], self.motions[self.pair, :3, 3]
        first = back_projected(matches.first_px, matches.first_depth_m, self.camera)
        moved = (rotation @ first[:, :, None])[:, :, 0] + shift
        moved[:, 2] = np.maximum(moved[:, 2], 0.05)
        x, y, z = moved.T
        predicted = np.column_stack([fx * x / z + cx, fy * y / z + cy, z])
        residual = predicted - np.column_stack([matches.second_px, matches.second_depth_m])
        by_moved = _projection_derivatives(moved, fx, fy)
        by_first = by_moved @ rotation
        by_camera = by_first @ _back_projection_derivatives(matches, self.camera)
        by_camera[:, 0, 0] += x / z
        by_camera[:, 1, 1] += y / z
        by_camera[:, 0, 2] += 1
        by_camera[:, 1, 3] += 1
        jacobian = np.concatenate([by_moved @ _motion_derivatives(moved), by_camera], axis=2)
        whitening = np.linalg.inv(np.linalg.cholesky(self._covariance(by_first, first)))
        return _Linear((whitening @ residual[:, :, None])[:, :, 0], whitening @ jacobian)

    def _covariance(self, by_first: Float64Array, first: Float64Array) -> Float64Array:
        """Covariances (M, 3, 3) of the errors, from those of pixels and depths of both views."""
        matches = self.matches
        by_measured = np.zeros((len(matches), 3, 3))
        by_measured[:, 0, 0], by_measured[:, 1, 1] = (matches.first_depth_m[:, None] / self.camera[:2]).T
        by_measured[:, :, 2] = first / matches.first_depth_m[:, None]
        propagated = by_first @ by_measured
        of_px = (self.px_scale * matches.sigma_px) ** 2
        variances = [
            np.column_stack([of_px, of_px, (self.depth_scale * self.noise.at_rest(depth)) ** 2])
            for depth in (matches.first_depth_m, matches.second_depth_m)
        ]
        covariance = (propagated * variances[0][:, None, :]) @ propagated.transpose(0, 2, 1)
        covariance[:, range(3), range(3)] += variances[1]
        result: Float64Array = covariance
        return result


def _projection_derivatives(points: Float64Array, fx: float, fy: float) -> Float64Array:
    """Derivatives (M, 3, 3) of pixel and depth by points (M, 3)."""
    x, y, z = points.T
    result = np.zeros((len(points), 3, 3))
    result[:, 0, 0], result[:, 0, 2] = fx / z, -fx * x / z**2
    result[:, 1, 1], result[:, 1, 2] = fy / z, -fy * y / z**2
    result[:, 2, 2] = 1.0
    return result


def _back_projection_derivatives(matches: ViewMatches, camera: Float64Array) -> Float64Array:
    """Derivatives (M, 3, 4) of the first view's points by the camera (4,)."""
    result = np.zeros((len(matches), 3, 4))
    per_pixel = matches.first_depth_m[:, None] / camera[:2]
    rays = (matches.first_px - camera[2:]) / camera[:2]
    for axis in (0, 1):
        result[:, axis, axis] = -rays[:, axis] * per_pixel[:, axis]
        result[:, axis, 2 + axis] = -per_pixel[:, axis]
    return result


def _motion_derivatives(points: Float64Array) -> Float64Array:
    """Derivatives (M, 3, 6) of moved points (M, 3) by a left perturbation of their motion: turn, then shift."""
    x, y, z = points.T
    result = np.zeros((len(points), 3, 6))
    result[:, 0, 1], result[:, 0, 2] = z, -y
    result[:, 1, 0], result[:, 1, 2] = -z, x
    result[:, 2, 0], result[:, 2, 1] = y, -x
    result[:, range(3), range(3, 6)] = 1.0
    return result
