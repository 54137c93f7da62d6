"""Depth term of ICP: point-to-plane distances with projective association, as normal equations of a left perturbation.

Each iteration needs the equations alone; how well they fit is asked in the end.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from razer.arrays import Float32Array, Float64Array, IndexArray
from slam.frontend.depth_noise import DepthNoise
from slam.frontend.depth_pyramid import MIN_DEPTH_M, SurfaceGrid

MIN_NORMAL_COSINE = 0.8  # between the normals of points that may be one; noise alone turns normals by half as much
TUKEY = 3.0  # residuals beyond this many sigmas are outliers, at the finest level
HUBER = 1.5  # from so many sigmas on residuals weigh less, at the coarse level: 95 % efficient under normal noise
MIN_MATCHED = 100  # with fewer there is no depth term: six unknowns from noisy readings at a coarse grid
# Normals of n points of a bare wall, under noise of their own in each view, have up to this / sqrt(n) of their spread
# in common by chance: in 95 of 100 pairs of simulated views, along that of the three open axes that has most.
CHANCE = 4.5
NOTHING = np.zeros((6, 6)), np.zeros(6)


@dataclass(frozen=True, eq=False)
class DepthTerm:
    """Points that were matched, and their distances.

    overlap, the share of the source's points that fall on the target's image; agreement, the share of those with a
    reading that lie on it; is_enough, whether these are so many that they say anything; strict, whether outliers are
    left out. Of the N that lie on it: points (3, N) in the target's frame, normals of both views there (3, N), scale
    (N,) = 1 / sigma of depth, residuals (N,) in sigmas.
    """

    overlap: float
    agreement: float
    is_enough: bool
    strict: bool
    points: Float32Array
    normals: Float32Array
    own_normals: Float32Array
    scale: Float32Array
    residuals: Float32Array

    @classmethod
    def of(
        cls,
        source: SurfaceGrid,
        target: SurfaceGrid,
        pose: Float64Array,
        noise: DepthNoise,
        reach_m: float,
        strict: bool,
    ) -> DepthTerm:
        """Match the points that project onto each other (Blais and Levine 1995; Chen and Medioni 1992).

        Args:
            source: the view that is moved.
            target: the view it is brought to.
            pose: target_from_source (4, 4).
            noise: of the depth of both views, by which distances count.
            reach_m: how far apart points may be.
            strict: whether outliers are left out or, as long as it is not clear which ones they are, only weigh less.
        """
        points = _moved(source.sample_points, pose)
        inside, pixel = _projected(points, target)
        overlap = len(inside) / max(points.shape[1], 1)
        with_reading = np.flatnonzero(np.take(target.valid, pixel))
        inside, pixel = np.take(inside, with_reading), np.take(pixel, with_reading)
        moved, normal = _columns(points, inside), _columns(target.normals, pixel)
        gap = _columns(target.points, pixel) - moved
        distance = _dot(gap, normal)
        own_normal = pose[:3, :3].astype(np.float32) @ _columns(source.sample_normals, inside)
        facing, near = _dot(own_normal, normal), _dot(gap, gap) < 4 * reach_m**2
        is_matched = near & (np.abs(distance) < reach_m) & (facing > MIN_NORMAL_COSINE)
        matched = np.flatnonzero(is_matched)
        agreement = len(matched) / max(len(inside), 1)
        moved, normal, own_normal = (_columns(each, matched) for each in (moved, normal, own_normal))
        distance, is_enough = np.take(distance, matched), len(matched) >= MIN_MATCHED
        scale = np.reciprocal(noise.sigma(moved[2], distance)) if is_enough else np.zeros_like(distance)
        return cls(overlap, agreement, is_enough, strict, moved, normal, own_normal, scale, distance * scale)

    @cached_property
    def equations(self) -> tuple[Float64Array, Float64Array]:
        """Information (6, 6) and gradient (6,), 0 where too few points were matched."""
        if not self.is_enough:
            return NOTHING
        information, gradient = self._weighted @ self._jacobian.T, self._weighted @ self.residuals
        return information.astype(np.float64), gradient.astype(np.float64)

    @property
    def shape_information(self) -> Float64Array:
        """The part (6, 6) of the information that normals of both views have in common: the noise of one view's is not
        that of the other's, so that it is shape."""
        information = self.equations[0]
        if not (self.strict and self.is_enough):
            return information
        in_common = (self._weighted @ jacobian(self.points, self.own_normals, self.scale).T).astype(np.float64)
        return in_common - CHANCE / np.sqrt(len(self.residuals)) * (information - in_common)

    @property
    def fit(self) -> float:
        """Share of all the source's points that lie on the target, each counting the less the farther off."""
        if not self.is_enough:
            return 0.0
        return self.overlap * self.agreement * float(weights(self.residuals, strict=True).mean())

    @property
    def rms(self) -> float:
        """Root mean square of the residuals in sigmas, as they are weighted."""
        if not self.is_enough:
            return float("inf")
        total = max(float(self._weights.sum()), 1e-9)
        return float(np.sqrt((self._weights * self.residuals**2).sum() / total))

    @cached_property
    def _weights(self) -> Float32Array:
        return weights(self.residuals, self.strict)

    @cached_property
    def _jacobian(self) -> Float32Array:
        return jacobian(self.points, self.normals, self.scale)

    @cached_property
    def _weighted(self) -> Float32Array:
        return self._jacobian * self._weights


def jacobian(points: Float32Array, normals: Float32Array, scale: Float32Array) -> Float32Array:
    """Of how far points (3, N) lie along the given normals, times scale (N,), by a left perturbation (6, N): by so much
    their distances to the planes become less."""
    result = np.empty((6, points.shape[1]), np.float32)
    (x, y, z), (a, b, c) = points, np.multiply(normals, scale, out=result[3:])
    result[0], result[1], result[2] = y * c - z * b, z * a - x * c, x * b - y * a
    return result


def weights(residuals: Float32Array, strict: bool) -> Float32Array:
    """Huber's, whose single minimum draws from afar, or Tukey's, which leave outliers out."""
    if strict:
        return np.square(1 - np.minimum((residuals / TUKEY) ** 2, 1))
    return np.minimum(1, HUBER / np.maximum(np.abs(residuals), np.float32(1e-6)))


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
