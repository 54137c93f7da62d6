"""Connected components of the equally labelled vertices of a mesh."""

from __future__ import annotations

from itertools import product

import numpy as np
from scipy.sparse import coo_matrix
from scipy.sparse.csgraph import connected_components

from razer.arrays import Float32Array, Float64Array, Int32Array, Int64Array

MIN_AREA_M2 = 0.005  # a scrap of 7 x 7 cm is no instance
CELL_M = 0.02  # holes no wider than this divide nothing
_BITS = 14
_NEIGHBOURS = np.array([step for step in product((-1, 0, 1), repeat=3) if step > (0, 0, 0)])


def connected_parts(points: Float32Array, triangles: Int32Array, labels: Int32Array) -> Int32Array:
    """A number from 1 for each connected part of one label, (V,); 0 where the label is 0 or the part is smaller than
    MIN_AREA_M2. Vertices are connected by edges, and where they lie in neighbouring cells of CELL_M."""
    cells, cell_of = np.unique(_keys(points, labels), return_inverse=True)
    corners = np.concatenate([triangles[:, [0, 1]], triangles[:, [1, 2]], triangles[:, [2, 0]]])
    along = cell_of[corners[labels[corners[:, 0]] == labels[corners[:, 1]]]]
    pairs = np.concatenate([along, *(_beside(cells, step) for step in _NEIGHBOURS)])
    graph = coo_matrix((np.ones(len(pairs)), tuple(pairs.T)), (len(cells), len(cells)))
    n_parts, part = connected_components(graph, directed=False)
    of_vertex = part[cell_of]
    within = (labels[triangles] == labels[triangles[:, :1]]).all(axis=1)
    areas = np.bincount(of_vertex[triangles[within, 0]], _areas(points, triangles[within]), n_parts)
    is_instance = areas >= MIN_AREA_M2
    is_instance[of_vertex[labels <= 0]] = False
    numbers = np.where(is_instance, np.cumsum(is_instance), 0)
    return numbers[of_vertex].astype(np.int32)


def _keys(points: Float32Array, labels: Int32Array) -> Int64Array:
    """One number for each label and cell, (V,)."""
    cells = np.floor(np.nan_to_num(points.astype(np.float64)) / CELL_M).astype(np.int64)
    x, y, z = ((cells - cells.min(axis=0, initial=0) + 1) % 2**_BITS).T
    return (((labels.astype(np.int64) << _BITS | x) << _BITS | y) << _BITS) | z


def _beside(cells: Int64Array, step: Int64Array) -> Int64Array:
    """Which of the sorted cells (C,) has which beside it in one direction, (P, 2)."""
    x, y, z = step
    other = cells + (((x << _BITS) + y) << _BITS) + z
    place = np.searchsorted(cells, other).clip(0, len(cells) - 1)
    there = np.flatnonzero(cells[place] == other)
    return np.stack([there, place[there]], axis=1)


def _areas(points: Float32Array, triangles: Int32Array) -> Float64Array:
    a, b, c = (points[triangles[:, k]].astype(np.float64) for k in range(3))
    areas: Float64Array = np.linalg.norm(np.cross(b - a, c - a), axis=1) / 2
    return areas
