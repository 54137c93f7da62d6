"""Tessellation of objects into fine meshes: evenly spaced vertices that know their instance and normal."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from data_tools.synthetic.shapes.solids import quad_normals
from data_tools.synthetic.shapes.thing import Thing
from razer.arrays import Float64Array, Int32Array, Int64Array

MOST_VERTICES = 10_000_000  # some 3 GB while they are worked out
_WELD_M = 1e-4


@dataclass(frozen=True, slots=True)
class SampledSurface:
    """vertices (V, 3) float64 metres, outward unit normals (V, 3), instances (V,) int32, triangles (T, 3) int32."""

    vertices: Float64Array
    normals: Float64Array
    instances: Int32Array
    triangles: Int32Array


def affordable_spacing_m(things: Mapping[int, Thing], spacing_m: float) -> float:
    """The spacing itself, or the least one at which the surface of things has no more than MOST_VERTICES."""
    quads = np.concatenate([solid.quads for thing in things.values() for solid in thing.solids])
    diagonals = quads[:, 2] - quads[:, 0], quads[:, 3] - quads[:, 1]
    area_m2 = float(np.linalg.norm(np.cross(*diagonals), axis=1).sum()) / 2
    return max(spacing_m, float(np.sqrt(area_m2 / MOST_VERTICES)))


def tessellate(things: Mapping[int, Thing], spacing_m: float) -> SampledSurface:
    """Split every quad of things (instance id -> Thing) into cells of at most spacing_m, corners shared."""
    vertices, normals, instances, triangles = [], [], [], []
    offset = 0
    for number, thing in things.items():
        for solid in thing.solids:
            for quad, normal in zip(solid.quads, quad_normals(solid.quads), strict=True):
                points, cells = _split(quad, spacing_m)
                vertices.append(points)
                normals.append(np.broadcast_to(normal, points.shape))
                instances.append(np.full(len(points), number, np.int32))
                triangles.append(cells + offset)
                offset += len(points)
    return _welded(*(np.concatenate(part) for part in (vertices, normals, instances, triangles)))


def _split(quad: Float64Array, spacing_m: float) -> tuple[Float64Array, Int64Array]:
    """A grid over one quad: points (P, 3) and triangles (T, 3)."""
    edges = np.linalg.norm(np.roll(quad, -1, axis=0) - quad, axis=1)
    columns = max(1, int(np.ceil(max(edges[0], edges[2]) / spacing_m - 1e-6)))
    rows = max(1, int(np.ceil(max(edges[1], edges[3]) / spacing_m - 1e-6)))
    s = np.linspace(0, 1, columns + 1)[:, None]
    t = np.linspace(0, 1, rows + 1)[:, None, None]
    low, high = quad[0] + s * (quad[1] - quad[0]), quad[3] + s * (quad[2] - quad[3])
    points = (low + t * (high - low)).reshape(-1, 3)
    number = np.arange(len(points)).reshape(rows + 1, columns + 1)
    a, b, c, d = (number[i : i + rows, j : j + columns].ravel() for i, j in ((0, 0), (0, 1), (1, 1), (1, 0)))
    return points, np.concatenate([np.stack([a, b, c], axis=1), np.stack([a, c, d], axis=1)])


def _welded(vertices: Float64Array, normals: Float64Array, instances: Int32Array, triangles: NDArray) -> SampledSurface:
    """Merge the vertices of one instance that coincide, averaging their normals, and drop empty triangles."""
    cells = np.rint((vertices - vertices.min(axis=0)) / _WELD_M).astype(np.int64)
    x, y, _ = cells.max(axis=0) + 1
    key = ((instances.astype(np.int64) * (cells[:, 2].max() + 1) + cells[:, 2]) * y + cells[:, 1]) * x + cells[:, 0]
    _, first, where = np.unique(key, return_index=True, return_inverse=True)
    sums = [np.bincount(where, weights=normals[:, k], minlength=len(first)) for k in range(3)]
    summed = np.stack(sums, axis=1).astype(np.float64)
    summed /= np.maximum(np.linalg.norm(summed, axis=1, keepdims=True), 1e-12)
    welded = where[triangles].astype(np.int32)
    a, b, c = welded.T
    return SampledSurface(vertices[first], summed, instances[first], welded[(a != b) & (b != c) & (a != c)])
