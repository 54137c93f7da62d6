"""Connected components of the equally labelled vertices of a mesh."""

from __future__ import annotations

import numpy as np
from scipy.sparse import coo_matrix
from scipy.sparse.csgraph import connected_components

from razer.arrays import Float32Array, Float64Array, Int32Array, Int64Array

MIN_AREA_M2 = 0.005  # a scrap of 7 x 7 cm is no instance
_WELD_M = 1e-4


def connected_parts(points: Float32Array, triangles: Int32Array, labels: Int32Array) -> Int32Array:
    """A number from 1 for each connected part of one label, (V,); 0 where the label is 0 or the part is smaller than
    MIN_AREA_M2. Vertices at one place are connected."""
    same = labels[triangles[:, :1]] == labels[triangles]
    within = same.all(axis=1)
    welded = _welded(points, labels)
    corners = welded[triangles]
    ends = np.concatenate([corners[same[:, k]][:, [0, k]] for k in (1, 2)])
    other = labels[triangles[:, 1]] == labels[triangles[:, 2]]
    ends = np.concatenate([ends, corners[other][:, 1:]])
    count = int(welded.max(initial=-1)) + 1
    _, part = connected_components(coo_matrix((np.ones(len(ends)), ends.T), (count, count)), directed=False)
    of_vertex = part[welded]
    areas = np.bincount(of_vertex[triangles[within, 0]], _areas(points, triangles[within]), part.max(initial=-1) + 1)
    is_instance = areas >= MIN_AREA_M2
    numbers = np.where(is_instance, np.cumsum(is_instance), 0)
    return np.where(labels > 0, numbers[of_vertex], 0).astype(np.int32)


def _welded(points: Float32Array, labels: Int32Array) -> Int64Array:
    """One number for all vertices of a label at one place, (V,)."""
    cells = np.rint(np.nan_to_num(points.astype(np.float64)) / _WELD_M).astype(np.int64)
    _, numbers = np.unique(np.column_stack([cells, labels]), axis=0, return_inverse=True)
    return numbers.ravel()


def _areas(points: Float32Array, triangles: Int32Array) -> Float64Array:
    a, b, c = (points[triangles[:, k]].astype(np.float64) for k in range(3))
    return np.linalg.norm(np.cross(b - a, c - a), axis=1) / 2
