"""Point-to-triangle distances."""

from __future__ import annotations

import numpy as np

from razer.arrays import BoolArray, FloatArray


def squared_distances(points: FloatArray, corners: FloatArray) -> FloatArray:
    """The squared distance (N,) of each point (3, N) from its own triangle (3 corners, 3, N), degenerate ones too."""
    first, second, third = corners
    to_second, to_third, to_point = second - first, third - first, points - first
    best = _from_segment(to_point, to_second)
    np.minimum(best, _from_segment(to_point, to_third), out=best)
    np.minimum(best, _from_segment(points - second, third - second), out=best)
    inside, offset = _from_inside(to_point, to_second, to_third)
    return np.where(inside, np.minimum(best, _dot(offset, offset)), best)


def _dot(a: FloatArray, b: FloatArray) -> FloatArray:
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


def _from_segment(to_point: FloatArray, along: FloatArray) -> FloatArray:
    length = _dot(along, along)
    share = np.clip(_dot(to_point, along) / np.where(length > 0, length, 1.0), 0.0, 1.0)
    offset = to_point - share * along
    return _dot(offset, offset)


def _from_inside(to_point: FloatArray, to_second: FloatArray, to_third: FloatArray) -> tuple[BoolArray, FloatArray]:
    """Whether the foot of the perpendicular lies in the triangle, by barycentric coordinates, and the perpendicular."""
    d00, d01, d11 = _dot(to_second, to_second), _dot(to_second, to_third), _dot(to_third, to_third)
    d20, d21 = _dot(to_point, to_second), _dot(to_point, to_third)
    area = d00 * d11 - d01 * d01
    v, w = d11 * d20 - d01 * d21, d00 * d21 - d01 * d20
    inside = (v >= 0) & (w >= 0) & (v + w <= area) & (area > 0)
    area = np.where(area > 0, area, 1.0)
    return inside, to_point - (v / area) * to_second - (w / area) * to_third
