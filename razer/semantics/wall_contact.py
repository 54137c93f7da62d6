"""Wall contact: whether a thing touches a wall, stands close to its plane, or lies flat on it and so may hang there."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from razer.arrays import Float64Array
from razer.semantics.upright_instance import UprightInstance

AGAINST_M = 0.1  # 5 cm of air, masks that are shrunk by one or two voxels on either side
_CONTACTS = 3
_AROUND_M = 0.5  # how far round a thing the wall behind it is looked for: the thing itself hides the rest
_FEWEST, _DIRECTIONS = 50, 36
_COPLANAR, _COPLANAR_M = 0.95, 0.03
_EDGE = 0.05  # share of a thing's surface that may lie nearer to the wall, or farther, as borders of masks do
# What hangs is flat: it stands out from the wall by this much at most, and is this many times as wide and as high.
_FLAT_M, _SLENDER = 0.15, 2.5


@dataclass(frozen=True, slots=True)
class WallPlane:
    """The upright plane of a wall near a thing: normal (3,) into the room, offset along it, the points (N, 3) seen."""

    normal: Float64Array
    offset: float
    points: Float64Array

    def along(self, points: Float64Array) -> Float64Array:
        """Where points (N, 3) lie along the wall (N,), horizontally, in metres."""
        return np.asarray(points[:, 0] * -self.normal[1] + points[:, 1] * self.normal[0])

    def is_behind(self, source: UprightInstance) -> bool:
        """Whether some of a thing is close to the wall."""
        return int((np.abs(self.in_front_m(source.points)) <= AGAINST_M).sum()) >= _CONTACTS

    def in_front_m(self, points: Float64Array) -> Float64Array:
        """How far points (N, 3) lie in front of the wall (N,)."""
        return np.asarray(points @ self.normal - self.offset)


def wall_plane(source: UprightInstance, target: UprightInstance) -> WallPlane | None:
    """The plane of what of `target` stands upright round `source`, or below it; None where nothing does.

    Args:
        source: the thing.
        target: a wall, or any surface that may hold some.
    """
    reach = np.array([_AROUND_M, _AROUND_M, 0.0])
    low, high = source.bounds[0] - reach, source.bounds[1] + reach
    rows = ((target.steep[:, :2] >= low[:2]) & (target.steep[:, :2] <= high[:2])).all(axis=1)
    rows &= target.steep[:, 2] <= high[2]
    points, normals = target.steep[rows], target.steep_normals[rows]
    if len(points) < _FEWEST:
        return None
    normal = _main_direction(normals)
    offsets = (points @ normal)[facing := normals @ normal > _COPLANAR]
    if len(offsets) < _FEWEST:
        return None
    nearest = np.argpartition(source.coarse_tree.query(points[facing])[0], _FEWEST - 1)[:_FEWEST]
    coplanar = np.abs(offsets - np.median(offsets[nearest])) <= _COPLANAR_M
    if coplanar.sum() < _FEWEST:
        return None
    return WallPlane(normal, float(np.median(offsets[coplanar])), points[facing][coplanar])


def _main_direction(normals: Float64Array) -> Float64Array:
    """The horizontal direction (3,) in which most of the surface faces: corners and edges tilt the mean."""
    turns = np.arctan2(normals[:, 1], normals[:, 0]) / (2 * np.pi)
    bins = np.floor(turns * _DIRECTIONS).astype(np.int64) % _DIRECTIONS
    counts = np.bincount(bins, minlength=_DIRECTIONS)
    most = int((counts + np.roll(counts, -1) + np.roll(counts, 1)).argmax())
    near = (bins - most + 1) % _DIRECTIONS <= 2
    mean = np.median(normals[near], axis=0) * [1.0, 1.0, 0.0]
    return np.asarray(mean / np.linalg.norm(mean))


def is_against(source: UprightInstance, target: UprightInstance) -> bool:
    """Whether `source` touches the upright surface of a wall, or of a sheet that stands like one, and is none, or
    stands close to the plane of a wall that goes on behind it."""
    if not target.is_wall or (source.is_wall and source.is_sheet and source.box.volume > target.box.volume):
        return False
    return _touches(source, target) or (target.stuff and _is_before(source, target))


def _touches(source: UprightInstance, target: UprightInstance) -> bool:
    low, high = source.bounds[0] - AGAINST_M, source.bounds[1] + AGAINST_M
    steep = target.steep[((target.steep >= low) & (target.steep <= high)).all(axis=1)]
    near = source.tree.query(steep, distance_upper_bound=AGAINST_M)[0] if len(steep) else np.zeros(0)
    return int(np.isfinite(near).sum()) >= _CONTACTS


def _is_before(source: UprightInstance, target: UprightInstance) -> bool:
    """Whether the back of `source` is close to a wall that is seen on both sides of its middle, and at its height."""
    plane = wall_plane(source, target)
    if plane is None or not plane.is_behind(source):
        return False
    beside = plane.along(plane.points[plane.points[:, 2] >= source.heights_m[0]])
    middle = float(np.median(plane.along(source.sample)))
    return len(beside) > 0 and float(beside.min()) <= middle <= float(beside.max())


def lies_flat(source: UprightInstance, plane: WallPlane) -> bool:
    """Whether `source` is a sheet on a wall, as pictures, windows and radiators are."""
    out_m = float(np.quantile(plane.in_front_m(source.sample), 1 - _EDGE))
    low, _, high = source.heights_m
    wide = float(np.ptp(np.quantile(plane.along(source.sample), [_EDGE, 1 - _EDGE])))
    return 0 < out_m <= _FLAT_M and min(high - low, wide) >= _SLENDER * out_m
