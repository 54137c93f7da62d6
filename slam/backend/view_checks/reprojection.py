"""Reprojection of the sparse readings of one view into another, and how far off they may lie.

Checks ask the same of the same views, one after the other and of one against many, so what was worked out is kept.
"""

from __future__ import annotations

from functools import lru_cache
from typing import NamedTuple

import numpy as np

from razer.arrays import Float32Array, Float64Array, IndexArray
from slam.frontend.depth_pyramid import MIN_DEPTH_M
from slam.frontend.keyframes import View
from slam.frontend.sparse_readings import SparseReadings, pixel_rays
from slam.frontend.view_registration import EXPOSURE_GAP_S

KEPT_VIEWS = 160  # all of few pictures that are matched in no order; each takes some 100 kB
KEPT_PAIRS = 256  # space is compared of all pairs of a place before colours are; each takes 30 kB at the most


class _Read(NamedTuple):
    """What readings are: their pixels (M,), rows one after the other, their rays x / z and y / z and depths (M,)."""

    pixel: IndexArray
    u: Float32Array
    v: Float32Array
    depth: Float32Array


def reprojected(view: View, other: View, other_from_view: Float64Array) -> tuple[IndexArray, IndexArray, Float32Array]:
    """The readings of a view that fall on another's image: their pixels (M,) in the one and in the other, rows one
    after the other, and their depths (M,) before the other's camera, metres; to be read only.

    Args:
        view: the view whose readings they are.
        other: the view they are projected into.
        other_from_view: (4, 4) the motion between them.
    """
    return _reprojected(view.sparse, other.sparse, other_from_view.astype(np.float64).tobytes())


@lru_cache(maxsize=KEPT_PAIRS)
def _reprojected(
    readings: SparseReadings, others: SparseReadings, motion: bytes
) -> tuple[IndexArray, IndexArray, Float32Array]:
    pixel, u, v, depth = _read(readings)
    # Written out, as products of large and tiny matrices take longer.
    rows = np.frombuffer(motion).reshape(4, 4)[:3].tolist()
    x, y, z = ((a * u + b * v + c) * depth + shift for a, b, c, shift in rows)
    is_ahead = z > MIN_DEPTH_M
    if not is_ahead.all():
        ahead = np.flatnonzero(is_ahead)
        pixel, x, y, z = pixel[ahead], x[ahead], y[ahead], z[ahead]
    k, inverse_depth = others.intrinsics, np.reciprocal(z)
    column, row = np.rint(x * inverse_depth * k.fx + k.cx), np.rint(y * inverse_depth * k.fy + k.cy)
    inside = np.flatnonzero((column >= 0) & (column < k.width) & (row >= 0) & (row < k.height))
    there = row[inside] * k.width + column[inside]
    return pixel[inside], there.astype(np.intp), z[inside]


@lru_cache(maxsize=KEPT_VIEWS)
def _read(readings: SparseReadings) -> _Read:
    depth = flat_depth(readings)
    pixel = np.flatnonzero(depth > 0)
    u, v = (each[pixel].astype(np.float32) for each in pixel_rays(readings.intrinsics))
    return _Read(pixel, u, v, depth[pixel])


@lru_cache(maxsize=KEPT_VIEWS)
def flat_depth(readings: SparseReadings) -> Float32Array:
    """The depths (h * w,) of readings, rows one after the other, 0 where there is none; to be read only."""
    return readings.depth.ravel().astype(np.float32)


def smear_pixels(view: View, other: View) -> int:
    """How many pixels of the other view's readings may lie between where they are and where they belong, as far as is
    known how the two cameras turned."""
    turning_rad_s = max(float(np.linalg.norm(each.turning_rad_s)) for each in (view, other))
    return int(EXPOSURE_GAP_S * turning_rad_s * other.sparse.intrinsics.fx)
