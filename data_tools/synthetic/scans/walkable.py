"""Walkable floor of a scan: cells with floor beneath them and nothing between knees and head."""

from __future__ import annotations

from collections.abc import Iterator

import cv2
import numpy as np
from scipy.ndimage import binary_fill_holes

from data_tools.synthetic.layout.free_space import CELL_M, HEIGHTS_M, EmptyCells
from data_tools.synthetic.scans.surface import ScannedSurface
from razer.arrays import BoolArray, Float32Array, IndexArray, Uint8Array

KNEE_M = 0.3
_FLOOR_M = 0.15
_FLOOR_COS = 0.8
_GAP_M = 0.3  # holes of the floor no wider than twice this are floor too
_MARGIN_M = 0.5
_MOST_SAMPLES = 400  # along one edge


def walkable_cells(surface: ScannedSurface) -> Iterator[tuple[str, EmptyCells]]:
    """Where a camera may be carried above a surface whose floor is at z = 0, in words and as cells, the most cautious
    first: where a person can walk; where the arms reach over what is lower than 1 m; the same where no floor was
    scanned, above anything that was."""
    points, level = _samples(surface)
    origin = points[:, :2].min(axis=0).astype(np.float64) - _MARGIN_M
    shape = np.ceil((points[:, :2].max(axis=0) + _MARGIN_M - origin) / CELL_M).astype(int)
    cells = np.floor((points[:, :2] - origin) / CELL_M).astype(int)

    def covered(chosen: BoolArray) -> Uint8Array:
        grid = np.zeros(shape, np.uint8)
        grid[tuple(cells[chosen].T)] = 1
        return grid

    height = points[:, 2]
    floor = _without_gaps(covered(level & (np.abs(height) < _FLOOR_M)))
    body, head = (covered((height > low) & (height < HEIGHTS_M[1])) for low in (KNEE_M, HEIGHTS_M[0]))
    yield "where a person can walk", EmptyCells(origin, floor * (1 - body))
    yield "above floor and low furniture", EmptyCells(origin, floor * (1 - head))
    everything = _without_gaps(covered(height < HEIGHTS_M[0]))
    yield "above all that was scanned", EmptyCells(origin, everything * (1 - head))


def _without_gaps(grid: Uint8Array) -> Uint8Array:
    size = 2 * round(_GAP_M / CELL_M) + 1
    disc = cv2.getStructuringElement(cv2.MORPH_ELLIPSE, (size, size))
    margin = cv2.copyMakeBorder(grid, size, size, size, size, cv2.BORDER_CONSTANT, value=0)
    closed = cv2.morphologyEx(margin, cv2.MORPH_CLOSE, disc)[size:-size, size:-size]
    return binary_fill_holes(closed).astype(np.uint8)


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
