"""Floor and ceiling: the outermost level planes of a map, followed room by room."""

from __future__ import annotations

import numpy as np

from razer.arrays import BoolArray, Float64Array, Int64Array
from razer.surface_segmentation.surface import HEIGHT, Surface

FLOOR, CEILING = 1, -1  # which way they face
_BIN_M = 0.02
_MIN_AREA_M2 = 1.0
_MIN_SHARE = 0.2  # of the largest level: a seat is lower than a table, and no floor
_MAX_BEYOND = 0.03  # of all surface may lie outside of a floor or a ceiling
_CLEARLY_BEYOND_M = 0.15
_STEEPEST_COSINE = 0.9  # to find a level; 0.75 to belong to it
_ROOM_M = 0.6  # over which a floor is taken as level: drift and rugs are followed at this scale
_ROOM_RANGE_M = 0.06
_THICKNESS_M = 0.025
_MIN_CELL_VERTICES = 50


def level_plane(surface: Surface, facing: int) -> BoolArray:
    """Which vertices (V,) lie in the floor (`FLOOR`, facing up) or the ceiling (`CEILING`), whatever their colour; none
    where no level plane bounds the map."""
    heights, rising = surface.positions[:, HEIGHT] * facing, surface.normals[:, HEIGHT] * facing
    is_level = rising > _STEEPEST_COSINE
    level = _outermost_level(heights[is_level], surface.areas[is_level])
    if level is None or surface.areas[heights < level - _CLEARLY_BEYOND_M].sum() > _MAX_BEYOND * surface.areas.sum():
        return np.zeros(len(surface), np.bool_)
    near = np.flatnonzero(is_level & (np.abs(heights - level) < 2 * _ROOM_RANGE_M))
    local = _local_levels(surface, heights, near, level)
    return (rising > 0.75) & (np.abs(heights - local) < _THICKNESS_M)


def _outermost_level(heights: Float64Array, areas: Float64Array) -> float | None:
    """The lowest height at which much of the surface lies."""
    if not len(heights):
        return None
    low = heights.min() - 3 * _BIN_M
    bins = np.floor((heights - low) / _BIN_M).astype(np.int64)
    profile = np.convolve(np.bincount(bins, areas, bins.max() + 4), np.ones(5), "same")
    enough = np.flatnonzero(profile >= max(_MIN_AREA_M2, _MIN_SHARE * profile.max()))
    if not len(enough):
        return None
    first = max(enough[0] - 4, 0)
    peak = first + int(profile[first : enough[0] + 5].argmax())
    return float(low + (peak + 0.5) * _BIN_M)


def _local_levels(surface: Surface, heights: Float64Array, near: Int64Array, level: float) -> Float64Array:
    """The level (V,) at each vertex: the median of those near the level in its square of the plan."""
    squares = np.floor(surface.positions[:, :2] / _ROOM_M).astype(np.int64)
    squares -= squares.min(axis=0)
    square = squares[:, 0] * (squares[:, 1].max() + 1) + squares[:, 1]
    order = near[np.lexsort((heights[near], square[near]))]
    numbers, starts, counts = np.unique(square[order], return_index=True, return_counts=True)
    medians = np.full(square.max() + 1, level)
    known = counts >= _MIN_CELL_VERTICES
    found = heights[order[(starts + counts // 2)[known]]]
    medians[numbers[known]] = np.where(np.abs(found - level) < _ROOM_RANGE_M, found, level)
    return medians[square]
