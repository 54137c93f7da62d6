"""Walkable floor of a scan: cells with floor beneath them and nothing between knees and head."""

from __future__ import annotations

import cv2
import numpy as np

from data_tools.synthetic.layout.free_space import CELL_M, HEIGHTS_M, EmptyCells
from data_tools.synthetic.scans.surface import ScannedSurface
from razer.arrays import BoolArray, Float32Array, Float64Array, IndexArray, Uint8Array

GROUNDS = ("where a person can walk", "above floor and low furniture", "above all that was scanned")
KNEE_M, BODY_M = 0.3, 0.15
_FLOOR_M = 0.15
_FLOOR_COS = 0.8
_GAP_M = 0.3  # holes of the floor no wider than twice this are floor too
_MARGIN_M = 0.5
_MOST_SAMPLES = 400  # along one edge


def walkable_cells(surface: ScannedSurface, ground: str) -> EmptyCells:
    """Where a camera may be carried above a surface whose floor is at z = 0, by one of GROUNDS.

    They are floor with nothing from the knees to the chest within BODY_M; floor and what stands on it lower than 1 m,
    which the arms reach over; and, where no floor was scanned, all that is lower than 1 m.
    """
    points, level = _samples(surface)
    origin = points[:, :2].min(axis=0).astype(np.float64) - _MARGIN_M
    shape = np.ceil((points[:, :2].max(axis=0) + _MARGIN_M - origin) / CELL_M).astype(int)
    cells = np.floor((points[:, :2] - origin) / CELL_M).astype(int)

    def covered(chosen: BoolArray) -> Uint8Array:
        grid = np.zeros(shape, np.uint8)
        grid[tuple(cells[chosen].T)] = 1
        return grid

    height = points[:, 2]
    at_camera = covered((height > HEIGHTS_M[0]) & (height < HEIGHTS_M[1]))
    scanned_floor = height < HEIGHTS_M[0] if ground == GROUNDS[2] else level & (np.abs(height) < _FLOOR_M)
    allowed = _without_gaps(covered(scanned_floor))
    if ground == GROUNDS[0]:
        low = covered((height > KNEE_M) & (height < HEIGHTS_M[0]))
        allowed = allowed & ~_grown(low, BODY_M)
    return EmptyCells(origin, 1 - at_camera, allowed)


def _without_gaps(grid: Uint8Array) -> BoolArray:
    margin = round(2 * _GAP_M / CELL_M)
    padded = np.pad(grid, margin)
    return ~_grown((~_grown(padded, _GAP_M)).astype(np.uint8), _GAP_M)[margin:-margin, margin:-margin]


def _grown(grid: Uint8Array, by_m: float) -> BoolArray:
    """The cells (I, J) no further than by_m from one that is set."""
    distance_m: Float64Array = cv2.distanceTransform(1 - grid, cv2.DIST_L2, cv2.DIST_MASK_PRECISE) * CELL_M
    return distance_m <= by_m


def _samples(surface: ScannedSurface) -> tuple[Float32Array, BoolArray]:
    """Points (P, 3) all over the triangles, closer than a cell, and whether each lies on level surface."""
    corners = surface.vertices[surface.triangles]
    edges = np.linalg.norm(corners - np.roll(corners, 1, axis=1), axis=2).max(axis=1)
    counts = np.ceil(edges / (0.7 * CELL_M)).astype(np.intp).clip(1, _MOST_SAMPLES)
    points, owners = list[Float32Array](), list[IndexArray]()
    for count in np.unique(counts):
        chosen = np.flatnonzero(counts == count)
        weights = _lattice(int(count))
        points.append(np.einsum("pk,tkc->tpc", weights, corners[chosen]).reshape(-1, 3).astype(np.float32))
        owners.append(np.repeat(chosen, len(weights)))
    level = np.abs(surface.normals[:, 2]) > _FLOOR_COS
    return np.concatenate(points), level[np.concatenate(owners)]


def _lattice(count: int) -> Float32Array:
    """Barycentric weights (P, 3) of evenly spaced points of a triangle, `count` steps along each edge."""
    i, j = np.meshgrid(np.arange(count + 1), np.arange(count + 1))
    inside = i + j <= count
    second, third = i[inside] / count, j[inside] / count
    return np.stack([1 - second - third, second, third], axis=1).astype(np.float32)
