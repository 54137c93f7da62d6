"""Matched features of two views that have depth in both, and the rigid motion between them by RANSAC (Fischler and
Bolles 1981) over absolute orientation (Horn 1987): what intrinsics are calibrated from."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, fields

import numpy as np

from razer.arrays import BoolArray, Float64Array
from razer.frame import Frame
from slam.config import SlamConfig
from slam.frontend.color_calibration import ColorCalibration
from slam.frontend.depth_noise import DepthNoise
from slam.frontend.features import Features
from slam.frontend.rigid_matches import absolute_orientations
from slam.frontend.wide_features import WideFeatures, match_wide_features

REACH_PX = 2  # depth is the median of so many pixels round a feature each way, of an image 640 wide
EVEN_SHARE, EVEN_M = 0.03, 0.02  # where readings there differ by more, the feature lies at an edge of depth
HYPOTHESES = 96  # with half of the matches wrong, one set of three is right all but surely
START_SIGMAS = 3.0  # matches farther off say nothing of a start, whose intrinsics are only about right


@dataclass(frozen=True)
class DepthFeatures:
    """N features of a view that lie on a surface: pixels (N, 2), depth_m (N,), sigma_px (N,) of a pixel, and the same
    as features that can be matched."""

    pixels: Float64Array
    depth_m: Float64Array
    sigma_px: Float64Array
    features: Features

    @classmethod
    def of(cls, frame: Frame, config: SlamConfig) -> DepthFeatures:
        """Those of a frame whose colour lies on its depth."""
        k = frame.intrinsics
        found = WideFeatures(frame, ColorCalibration.nominal(), config).prominent
        pixels = found.rays.astype(np.float64) * (k.fx, k.fy) + (k.cx, k.cy)
        depth, is_even = _depth_around(frame, pixels)
        kept = np.flatnonzero(is_even)
        return cls(pixels[kept], depth[kept], found.sigma[kept].astype(np.float64) * k.fx, found.select(kept))


def _depth_around(frame: Frame, pixels: Float64Array) -> tuple[Float64Array, BoolArray]:
    """Median depth (N,) about pixels (N, 2), and where all readings there are of one surface."""
    k = frame.intrinsics
    reach = max(1, round(REACH_PX * k.width / 640))
    offsets = np.arange(-reach, reach + 1)
    column = (np.rint(pixels[:, 0]).astype(int)[:, None, None] + offsets).clip(0, k.width - 1)
    row = (np.rint(pixels[:, 1]).astype(int)[:, None, None] + offsets[:, None]).clip(0, k.height - 1)
    read = frame.depth[row, column].reshape(len(pixels), -1).astype(np.float64)
    if frame.has_color is not None:
        read[~frame.has_color[row, column].reshape(len(pixels), -1)] = 0.0
    depth = np.median(read, axis=1)
    spread = read.max(axis=1, initial=0.0) - read.min(axis=1, initial=np.inf)
    return depth, (read > 0).all(axis=1) & (spread < EVEN_SHARE * depth + EVEN_M)


@dataclass(frozen=True)
class ViewMatches:
    """M points that two views saw each: pixels (M, 2) and depth (M,) in metres of the first and the second, and
    sigma_px (M,) of a pixel."""

    first_px: Float64Array
    first_depth_m: Float64Array
    second_px: Float64Array
    second_depth_m: Float64Array
    sigma_px: Float64Array

    @classmethod
    def of(cls, first: DepthFeatures, second: DepthFeatures) -> ViewMatches:
        """The features that match."""
        a, b = match_wide_features(first.features, second.features).T
        sigma = np.maximum(first.sigma_px[a], second.sigma_px[b])
        return cls(first.pixels[a], first.depth_m[a], second.pixels[b], second.depth_m[b], sigma)

    @classmethod
    def joined(cls, parts: Sequence[ViewMatches]) -> ViewMatches:
        """Those of all parts, in their order."""
        return cls(*(np.concatenate([getattr(part, field.name) for part in parts]) for field in fields(cls)))

    def __len__(self) -> int:
        return len(self.sigma_px)

    def points(self, camera: Float64Array) -> tuple[Float64Array, Float64Array]:
        """The points (M, 3) in front of the first and of the second view by the pinhole camera (4,) fx, fy, cx, cy."""
        return (
            back_projected(self.first_px, self.first_depth_m, camera),
            back_projected(self.second_px, self.second_depth_m, camera),
        )


def back_projected(pixels: Float64Array, depth_m: Float64Array, camera: Float64Array) -> Float64Array:
    """Points (M, 3) of pixels (M, 2) at depths (M,) by the pinhole camera (4,) fx, fy, cx, cy."""
    return np.column_stack([(pixels - camera[2:]) / camera[:2], np.ones(len(pixels))]) * depth_m[:, None]


@dataclass(frozen=True)
class RigidStart:
    """A motion second_from_first (4, 4), which matches (M,) it explains, and what it leaves, each match at most 1."""

    second_from_first: Float64Array
    explained: BoolArray
    cost: float


def rigid_start(matches: ViewMatches, camera: Float64Array, noise: DepthNoise) -> RigidStart:
    """The motion that explains most of at least three matches under a pinhole camera (4,) fx, fy, cx, cy."""
    first, second = matches.points(camera)
    rng = np.random.default_rng(len(matches))
    samples = rng.random((HYPOTHESES, len(matches))).argpartition(2, axis=1)[:, :3]
    motions = absolute_orientations(first[samples], second[samples])
    errors = _squared_errors(matches, camera, noise, motions)
    best = int(errors.mean(axis=1).argmin())
    for _ in range(2):  # from three points to all that agree with them
        explained = errors[best] < 1
        if explained.sum() < 3:
            break
        motions = absolute_orientations(first[explained][None], second[explained][None])
        errors, best = _squared_errors(matches, camera, noise, motions), 0
    return RigidStart(motions[best], errors[best] < 1, float(errors[best].sum()))


def _squared_errors(
    matches: ViewMatches, camera: Float64Array, noise: DepthNoise, motions: Float64Array
) -> Float64Array:
    """Squared errors (K, M) of matches under motions (K, 4, 4), in START_SIGMAS, at most 1."""
    first, _ = matches.points(camera)
    moved = first @ motions[:, :3, :3].transpose(0, 2, 1) + motions[:, None, :3, 3]
    depth = np.maximum(moved[..., 2], 1e-3)
    off_px = moved[..., :2] / depth[..., None] * camera[:2] + camera[2:] - matches.second_px
    sigma_m = np.hypot(noise.at_rest(matches.first_depth_m), noise.at_rest(matches.second_depth_m))
    squared = (off_px**2).sum(axis=2) / (2 * matches.sigma_px**2)
    squared += ((moved[..., 2] - matches.second_depth_m) / sigma_m) ** 2
    return np.minimum(squared / START_SIGMAS**2, 1.0)
