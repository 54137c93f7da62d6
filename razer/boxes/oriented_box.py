"""Incremental point moments, and the oriented boxes that PCA makes of them (RAZER sections IV-B and IV-D)."""

from __future__ import annotations

from dataclasses import dataclass
from math import isfinite

import numpy as np

from razer.arrays import BoolArray, Float64Array

SURFACE_TRIM = 0.01  # share of surface points that may lie beyond either face: labels stray at borders
UNIT_CORNERS = np.array([[x, y, z] for x in (-0.5, 0.5) for y in (-0.5, 0.5) for z in (-0.5, 0.5)])


@dataclass(frozen=True, slots=True)
class PointMoments:
    """Count N, mean c (3,) and scatter S (3, 3) = sum (p - c)(p - c)^T of a set of points."""

    count: int
    mean: Float64Array
    scatter: Float64Array

    @classmethod
    def of(cls, points: Float64Array) -> PointMoments:
        """Moments of (N, 3) points, N >= 1 (RAZER eqs. 4 and 5)."""
        mean = points.mean(axis=0)
        centred = points - mean
        return cls(len(points), mean, centred.T @ centred)

    def __add__(self, other: PointMoments) -> PointMoments:
        """Moments of both sets together, without their points (RAZER eqs. 9 to 11)."""
        count = self.count + other.count
        mean = (self.count * self.mean + other.count * other.mean) / count
        gap = self.mean - other.mean
        scatter = self.scatter + other.scatter + self.count * other.count / count * np.outer(gap, gap)
        return PointMoments(count, mean, scatter)

    @property
    def covariance(self) -> Float64Array:
        """S / (N - 1), (3, 3); zero for a single point."""
        return self.scatter / max(self.count - 1, 1)

    @property
    def axes(self) -> Float64Array:
        """Principal axes as columns (3, 3), longest first, right-handed."""
        _, vectors = np.linalg.eigh(self.covariance)
        # The sign of an eigenvector is arbitrary: make its largest part positive, so that results repeat.
        u, v = (-vector if vector[np.abs(vector).argmax()] < 0 else vector for vector in (vectors[:, 2], vectors[:, 1]))
        (a, b, c), (d, e, f) = u.tolist(), v.tolist()
        return np.array([[a, d, b * f - c * e], [b, e, c * d - a * f], [c, f, a * e - b * d]])


@dataclass(frozen=True, slots=True)
class OrientedBox:
    """A box b = (c, R, s): center (3,) metres, rotation (3, 3) world_from_box, extent (3,) full edge lengths."""

    center: Float64Array
    rotation: Float64Array
    extent: Float64Array

    def __post_init__(self) -> None:
        if not all(map(isfinite, (*self.center, *self.extent))) or min(self.extent) < 0:
            raise ValueError(f"no box has center {self.center} and extent {self.extent}")

    @classmethod
    def around(cls, points: Float64Array, axes: Float64Array, trim: float = 0.0) -> OrientedBox:
        """The box along `axes` that holds (N, 3) points (RAZER eq. 6), but for a share `trim` at either end."""
        along = points @ axes
        low, high = (along.min(axis=0), along.max(axis=0))
        if trim > 0:
            low, high = np.quantile(along, [trim, 1 - trim], axis=0)
        return cls(axes @ ((low + high) / 2), axes, high - low)

    @classmethod
    def of_surface(cls, points: Float64Array) -> OrientedBox:
        """The box along the principal axes of surface points (N, 3), but for the outermost hundredth of them."""
        return cls.around(points, PointMoments.of(points).axes, SURFACE_TRIM)

    @classmethod
    def of_moments(cls, moments: PointMoments) -> OrientedBox:
        """The box about the centroid that, evenly filled, has this covariance: edges of sqrt(12) standard deviations
        along the principal axes (RAZER section IV-D, which fixes axes and leaves the factor open)."""
        axes = moments.axes
        variances = np.einsum("ij,ik,kj->j", axes, moments.covariance, axes)
        return cls(moments.mean, axes, np.sqrt(12 * np.maximum(variances, 0.0)))

    @property
    def volume(self) -> float:
        """Cubic metres."""
        return float(self.extent[0] * self.extent[1] * self.extent[2])

    def corners(self) -> Float64Array:
        """The eight corners (8, 3) in the world."""
        return self.center + (UNIT_CORNERS * self.extent) @ self.rotation.T

    def enclosing_bounds(self, margin_m: float = 0.0) -> Float64Array:
        """The axis-aligned box around it, (6,) as min xyz, max xyz (AABB_Enclose, RAZER eq. 7)."""
        half = np.abs(self.rotation) @ (self.extent / 2) + margin_m
        return np.concatenate([self.center - half, self.center + half])

    def contains(self, points: Float64Array, margin_m: float = 0.0) -> BoolArray:
        """Which of (N, 3) points lie inside, (N,)."""
        local = np.abs((points - self.center) @ self.rotation)
        inside: BoolArray = np.all(local <= self.extent / 2 + margin_m, axis=1)
        return inside

    def grown(self, margin_m: float) -> OrientedBox:
        """The same box with every face moved outwards."""
        return OrientedBox(self.center, self.rotation, self.extent + 2 * margin_m)
