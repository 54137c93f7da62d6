"""Intrinsics of the depth camera from pairs of views: least squares in one pinhole camera and a motion for each pair.

With a wrong focal length the world is stretched across the line of sight and not along it. What two views saw from the
same direction can still be laid upon each other; once the camera has turned it cannot, as what was stretched in the one
is not in the other. So pairs of views that turned tell the camera, and views that only moved forward tell nothing.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np

from razer.arrays import Float64Array, Int64Array
from razer.frame import Intrinsics
from slam.config import DepthSettings
from slam.frontend.depth_noise import DepthNoise
from slam.frontend.matched_views import ViewMatches, back_projected, rigid_start
from slam.se3 import exp_se3

FACTORS = 1.09 ** np.arange(-6, 7)  # of the guessed focal length, to start from: 0.6 to 1.68
MIN_MATCHES = 20  # of a pair that are explained; more than three times its unknowns
MIN_EXPLAINED = 0.3  # share of a pair's matches
MIN_PAIRS, MIN_GROUPS = 8, 4  # of views, and of stretches of the recording, for a spread to be measured
ITERATIONS = 12
# Prior: the focal length may be anything, pixels are square within a percent as far as the guess says, and the
# principal point lies within a few percent of the width where it is guessed.
PRIOR_FOCAL, PRIOR_ASPECT, PRIOR_CENTRE = 0.5, 0.01, 0.02
WORTH_A_WORD, SURE_SIGMAS = 0.04, 4.0  # share of the guessed focal length; what has been calibrated is not nagged at
MAX_SIGMA = 0.015  # of the focal length, as a share: with more, the guess may as well stay


@dataclass(frozen=True)
class ViewPair:
    """Matches of two views, and the stretch of the recording that they are of: pairs of one err together."""

    matches: ViewMatches
    group: int


@dataclass(frozen=True)
class IntrinsicsEstimate:
    """A pinhole camera from views, and the guess that it is from; sigma_px (4,), of fx, fy, cx and cy; n_pairs of views
    that it is from; `confident`: whether they determine it, else `reason` says why not."""

    guess: Intrinsics
    intrinsics: Intrinsics
    sigma_px: tuple[float, float, float, float]
    n_pairs: int
    reason: str = ""

    @property
    def confident(self) -> bool:
        """Whether the views determine the camera."""
        return not self.reason

    @property
    def contradicts_guess(self) -> bool:
        """Whether the focal length is surely another one, by more than is worth a word."""
        pairs = ((self.intrinsics.fx, self.guess.fx), (self.intrinsics.fy, self.guess.fy))
        off = max(abs(found / guess - 1) for found, guess in pairs)
        sigma = max(self.sigma_px[:2]) / self.guess.fx
        return self.confident and off > max(WORTH_A_WORD, SURE_SIGMAS * sigma)

    def to_json(self) -> dict[str, Any]:
        """fx, fy, cx, cy, their deviations, pairs, confident and reason; null = not known."""
        camera = self.intrinsics
        return {
            "fx": camera.fx,
            "fy": camera.fy,
            "cx": camera.cx,
            "cy": camera.cy,
            "sigma_px": [sigma if np.isfinite(sigma) else None for sigma in self.sigma_px],
            "pairs": self.n_pairs,
            "confident": self.confident,
            "reason": self.reason or None,
        }

    def __str__(self) -> str:
        if not self.confident:
            return f"cannot be refined: {self.reason}"
        camera, sigma = self.intrinsics, self.sigma_px
        return (
            f"focal lengths {camera.fx:.1f} {camera.fy:.1f} ± {max(sigma[:2]):.1f} pixels, centre {camera.cx:.1f} "
            f"{camera.cy:.1f} ± {max(sigma[2:]):.1f}, by {self.n_pairs} pairs of views"
        )


def estimate_intrinsics(pairs: Sequence[ViewPair], guess: Intrinsics, depth: DepthSettings) -> IntrinsicsEstimate:
    """The camera under which the views of each pair are of one rigid world.

    Args:
        pairs: matched views, best of cameras that turned between them.
        guess: the camera to start from, whose focal lengths may be off by a third.
        depth: the noise of the depth sensor.
    """
    noise = DepthNoise(depth)
    usable = [pair for pair in pairs if len(pair.matches) >= MIN_MATCHES]
    problem = _Problem.best(usable, guess, noise)
    if problem is None or len(problem.motions) < MIN_PAIRS or len(set(problem.groups.tolist())) < MIN_GROUPS:
        n_pairs = 0 if problem is None else len(problem.motions)
        reason = f"only {n_pairs} pairs of views show the same from two sides, of {MIN_PAIRS} needed all over"
        return IntrinsicsEstimate(guess, guess, (np.inf,) * 4, n_pairs, reason)
    solved = problem.solved()
    fx, fy, cx, cy = solved.camera.tolist()
    sigma = solved.sigma_px()
    return IntrinsicsEstimate(
        guess,
        Intrinsics(guess.width, guess.height, fx, fy, cx, cy),
        (sigma[0], sigma[1], sigma[2], sigma[3]),
        len(problem.motions),
        _doubt(solved.camera, sigma),
    )


def _doubt(camera: Float64Array, sigma: Float64Array) -> str:
    """Why an estimate cannot be trusted, in a plain line; empty where it can."""
    share = float((sigma[:2] / camera[:2]).max())
    if share > MAX_SIGMA:
        return (
            f"the views leave the focal length open by {share:.1%}, of which {MAX_SIGMA:.1%} is the limit: the camera "
            "must turn to and fro before things at several depths"
        )
    return ""


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


@dataclass
class _Problem:
    """A camera (4,) fx, fy, cx, cy, and motions second_from_first (P, 4, 4) of pairs; `starts` (P,), where the matches
    of each begin, `pair` (M,), the pair of each match, and `groups` (P,)."""

    guess: Float64Array
    width: int
    noise: DepthNoise
    matches: ViewMatches
    starts: Int64Array
    pair: Int64Array
    groups: Int64Array
    camera: Float64Array
    motions: Float64Array

    @classmethod
    def best(cls, pairs: Sequence[ViewPair], guess: Intrinsics, noise: DepthNoise) -> _Problem | None:
        """The start of the focal length under which rigid motions explain most; None where none does."""
        tried = [cls._start(pairs, guess, factor, noise) for factor in FACTORS.tolist()] if pairs else []
        _, problem = min(tried, key=lambda start: start[0], default=(0.0, None))
        return problem

    @classmethod
    def _start(
        cls, pairs: Sequence[ViewPair], guess: Intrinsics, factor: float, noise: DepthNoise
    ) -> tuple[float, _Problem | None]:
        guessed = np.array([guess.fx, guess.fy, guess.cx, guess.cy])
        camera = guessed * (factor, factor, 1.0, 1.0)
        starts = [rigid_start(pair.matches, camera, noise) for pair in pairs]
        cost = sum(start.cost for start in starts)
        kept = [
            (pair, start)
            for pair, start in zip(pairs, starts, strict=True)
            if start.explained.sum() >= max(MIN_MATCHES, MIN_EXPLAINED * len(pair.matches))
        ]
        if not kept:
            return cost, None
        sizes = np.array([len(pair.matches) for pair, _ in kept])
        return cost, cls(
            guessed,
            guess.width,
            noise,
            ViewMatches.joined([pair.matches for pair, _ in kept]),
            np.concatenate([[0], np.cumsum(sizes)[:-1]]),
            np.repeat(np.arange(len(kept)), sizes),
            np.array([pair.group for pair, _ in kept]),
            camera,
            np.stack([start.second_from_first for _, start in kept]),
        )

    def solved(self) -> _Problem:
        """The same after Gauss-Newton with Geman-McClure's weights, which leave outliers out."""
        for _ in range(ITERATIONS):
            normal = self._normal(self._linear())
            information, pull = self._prior()
            step = np.linalg.solve(normal.information + information, normal.gradients.sum(axis=0) + pull)
            self.camera = self.camera + step
            rest = normal.motion_gradients - normal.cross @ step
            turns = np.linalg.solve(normal.of_motion, rest[:, :, None])[:, :, 0]
            self.motions = np.stack([exp_se3(turn) @ old for turn, old in zip(turns, self.motions, strict=True)])
        return self

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
                [1 / fx / PRIOR_ASPECT, -1 / fy / PRIOR_ASPECT, 0, 0],
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
        variances = [
            np.column_stack([matches.sigma_px**2, matches.sigma_px**2, self.noise.at_rest(depth) ** 2])
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
