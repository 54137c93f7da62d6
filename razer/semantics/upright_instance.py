"""Upright instance: the surface of one instance with gravity along -z."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from scipy.spatial import ConvexHull, KDTree, QhullError

from razer.arrays import Float64Array
from razer.boxes.oriented_box import OrientedBox

_SAMPLES = 1500
# Share of the surface above and below which counts as noise: borders of masks leave some of a table on its cups.
_TRIM = 0.02
# A surface facing this much upwards carries things; one facing this little upwards can be leant against.
LEVEL, _STEEP = 0.7, 0.3
# What is this tall and this wide, and steep for the most part, is a wall or stands like one.
_WALL_HEIGHT_M, _WALL_WIDTH_M, _WALL_SHARE = 1.5, 1.5, 0.7
_SHEET_M = 0.25
# Noise tilts the surface of walls; floors and ceilings have next to no steep surface.
_STUFF_SHARE = 0.35
_FOOT_M = 0.06
# Slices of the height, of which so many in a row must be next to empty to part a thing from what lies below it.
_SLICE_M, _GAP_SLICES, _SPECK = 0.03, 3, 0.001
_FOOT_SAMPLES = 200


@dataclass(frozen=True)
class UprightInstance:
    """points (N, 3) of the surface and normals (N, 3), N >= 1, in metres with z upwards; box in the same axes; stuff,
    whether it is of a class that has no instances; name of its class, "" where it has none."""

    id: int
    points: Float64Array
    normals: Float64Array
    box: OrientedBox
    stuff: bool = False
    name: str = ""

    @cached_property
    def sample(self) -> Float64Array:
        """Some of the points, evenly chosen."""
        return self.points[:: max(1, len(self.points) // _SAMPLES)]

    @cached_property
    def tree(self) -> KDTree:
        """Index of all points."""
        return KDTree(self.points)

    @cached_property
    def coarse_tree(self) -> KDTree:
        """Index of the sample."""
        return KDTree(self.sample)

    @cached_property
    def plan(self) -> KDTree:
        """Index of the sample from above, (x, y)."""
        return KDTree(self.sample[:, :2])

    @cached_property
    def heights_m(self) -> tuple[float, float, float]:
        """Lowest, middle and highest z."""
        low, middle, high = np.quantile(self.points[:, 2], [_TRIM, 0.5, 1 - _TRIM])
        return float(low), float(middle), float(high)

    @cached_property
    def bounds(self) -> Float64Array:
        """Lowest and highest x, y, z (2, 3)."""
        return np.stack([self.points.min(axis=0), self.points.max(axis=0)])

    @cached_property
    def body(self) -> Float64Array:
        """Its points without what lies apart below: a label that leaked onto the floor is not the foot."""
        bins = np.floor((self.points[:, 2] - self.bounds[0, 2]) / _SLICE_M).astype(np.int64)
        is_empty = np.bincount(bins) < max(2.0, _SPECK * len(self.points))
        gaps = np.flatnonzero(np.convolve(is_empty, np.ones(_GAP_SLICES), mode="full") >= _GAP_SLICES)
        gaps = gaps[gaps < np.median(bins)]
        return self.points[bins > gaps[-1]] if len(gaps) else self.points

    def foot(self, trim: float, *, of_body: bool = False) -> Float64Array:
        """Some of the points (M, 3) at its bottom, M >= 1, once a share of the surface is left out below."""
        points = self.body if of_body else self.points
        low = np.partition(points[:, 2], rank := int(trim * len(points)))[rank]
        at_bottom = points[(points[:, 2] >= low) & (points[:, 2] <= low + _FOOT_M)]
        return at_bottom[:: max(1, len(at_bottom) // _FOOT_SAMPLES)]

    @cached_property
    def level(self) -> Float64Array:
        """The points (M, 3) of surfaces that face upwards."""
        return self.points[self.normals[:, 2] > LEVEL]

    @cached_property
    def steep(self) -> Float64Array:
        """The points (M, 3) of surfaces that stand upright."""
        return self.points[np.abs(self.normals[:, 2]) < _STEEP]

    @cached_property
    def steep_normals(self) -> Float64Array:
        """The normals (M, 3) of `steep`."""
        return self.normals[np.abs(self.normals[:, 2]) < _STEEP]

    @property
    def is_wall(self) -> bool:
        """Whether it stands upright and is large, as walls, doors and cupboards do."""
        share = len(self.steep) / len(self.points)
        if self.stuff:
            return share >= _STUFF_SHARE
        size = self.bounds[1] - self.bounds[0]
        return bool(size[2] >= _WALL_HEIGHT_M and max(size[:2]) >= _WALL_WIDTH_M and share >= _WALL_SHARE)

    @property
    def is_sheet(self) -> bool:
        """Whether it is as thin as a wall: a wardrobe is not."""
        return min(self.box.extent) <= _SHEET_M

    @cached_property
    def middle(self) -> Float64Array:
        """The middle of its outline from above, (x, y)."""
        low, high = np.quantile(self.points[:, :2], [_TRIM, 1 - _TRIM], axis=0)
        return np.asarray((low + high) / 2)

    @cached_property
    def _outline(self) -> Float64Array | None:
        """Half planes (K, 3) of the convex outline from above, as (normal, offset); None of a thin one."""
        try:
            return np.asarray(ConvexHull(self.sample[:, :2]).equations)
        except (QhullError, ValueError):
            return None

    def spans(self, position: Float64Array, margin_m: float) -> bool:
        """Whether its outline, from above, holds a position (x, y)."""
        if self._outline is None:
            return bool(self.plan.query(position)[0] <= margin_m)
        return bool((self._outline[:, :2] @ position + self._outline[:, 2] <= margin_m).all())
