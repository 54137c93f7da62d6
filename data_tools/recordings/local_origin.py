"""Local origin of coordinates far from zero, such as UTM's: maps are made of numbers too coarse for them."""

from __future__ import annotations

import numpy as np

from razer.arrays import Float64Array, FloatArray

Origin = tuple[float, float, float]
"""The translation world_from_map, metres: what is added to coordinates of a map to have those of its world."""

HERE: Origin = (0.0, 0.0, 0.0)
FAR_M = 10_000.0  # where float32 has steps of a millimetre
_STEP_M = 1000.0  # so that recordings of one place mostly have one origin


def local_origin(points: FloatArray) -> Origin:
    """Where points (N, 3) metres lie, in whole kilometres; HERE where they are near enough to zero. Points that are
    not finite do not count."""
    finite = points[np.isfinite(points).all(axis=1)]
    if not len(finite):
        return HERE
    middle = np.median(finite.astype(np.float64), axis=0)
    if np.abs(middle).max() <= FAR_M:
        return HERE
    x, y, z = (np.rint(middle / _STEP_M) * _STEP_M).tolist()
    return x, y, z


def origin_of(source: object) -> Origin:
    """The origin of a recording or a truth; HERE for those that know of none."""
    origin: Origin = getattr(source, "origin", HERE)
    return origin


def moved_origin(pose: Float64Array, origin: Origin) -> Float64Array:
    """A world_from_camera (4, 4), or several (N, 4, 4), as seen from an origin."""
    if origin == HERE:
        return pose
    local = pose.copy()
    local[..., :3, 3] -= origin
    return local
