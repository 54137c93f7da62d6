"""Point-to-surface distances, independent of the spacing of the surface's vertices."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from scipy.spatial import cKDTree

from razer.arrays import FloatArray, Int64Array, IntArray
from razer.metrics.surface.point_triangle import squared_distances

_CHUNK = 1 << 14
_CANDIDATES = 3
_MAX_INNER_POINTS = 2_000_000


class TriangleSurface:
    """V vertices (V, 3), metres, and T triangles (T, 3) of their numbers; without triangles a cloud of points.

    Triangles with edges longer than spacing_m also get points inside, as search keys, spacing_m apart at most
    (more where that would take more than two million points).
    """

    def __init__(self, vertices: FloatArray, triangles: IntArray | None = None, spacing_m: float = 0.05) -> None:
        vertices = np.asarray(vertices, np.float64)
        faces = np.zeros((0, 3), np.int64) if triangles is None else np.asarray(triangles, np.int64).reshape(-1, 3)
        corners = vertices[faces]
        self._corners = corners.reshape(-1, 9)
        self._centres = (corners[:, 0] + corners[:, 1] + corners[:, 2]) / 3
        self._radii = np.sqrt(_squared_lengths(corners - self._centres[:, None]).max(axis=1, initial=0.0))
        # No edge is longer than twice the way from the centre to the farthest corner.
        large = np.flatnonzero(2 * self._radii > spacing_m)
        inner, owner = _points_inside(corners[large], spacing_m)
        owner = large[owner]
        self._points = np.concatenate([vertices, inner])
        self._tree = cKDTree(self._points) if len(self._points) else None
        # Triangles by point, as in a sparse matrix of rows.
        point = np.concatenate([faces.ravel(), len(vertices) + np.arange(len(inner))])
        triangle = np.concatenate([np.repeat(np.arange(len(faces)), 3), owner])
        order = np.argsort(point, kind="stable")
        self._triangles = triangle[order]
        self._first = np.searchsorted(point[order], np.arange(len(self._points) + 1))

    def distances(self, points: FloatArray) -> FloatArray:
        """The distance (N,) of each point (N, 3), metres; infinite from an empty surface.

        It is the exact distance from the triangles at the three nearest vertices (or points inside a triangle) and from
        these themselves, so never too small, and 0 for the surface's own vertices."""
        points = np.asarray(points, np.float64)
        if self._tree is None or len(points) == 0:
            return np.full(len(points), np.inf)
        ranks = list(range(1, min(_CANDIDATES, len(self._points)) + 1))
        _, nearest = self._tree.query(points, k=ranks)
        squares = [self._squared_distances(points[part], nearest[part]) for part in _chunks(len(points))]
        return np.sqrt(np.concatenate(squares))

    def _squared_distances(self, points: FloatArray, nearest: Int64Array) -> FloatArray:
        """Squared distances (N,) of points (N, 3) from the triangles at the surface's points nearest to them (N, k)."""
        best = _squared_lengths(self._points[nearest[:, 0]] - points)
        for column in range(nearest.shape[1]):
            first, after = self._first[nearest[:, column]], self._first[nearest[:, column] + 1]
            for place in range(int((after - first).max(initial=0))):
                rows = np.flatnonzero(first + place < after)
                chosen = self._triangles[first[rows] + place]
                # A point farther from a triangle's bounding sphere than its best distance is no nearer to the triangle.
                to_centre = _squared_lengths(self._centres[chosen] - points[rows])
                is_candidate = to_centre <= (np.sqrt(best[rows]) + self._radii[chosen]) ** 2
                rows, chosen = rows[is_candidate], chosen[is_candidate]
                corners = np.ascontiguousarray(self._corners[chosen].T).reshape(3, 3, -1)
                best[rows] = np.minimum(best[rows], squared_distances(points[rows].T, corners))
        return best


def _squared_lengths(vectors: FloatArray) -> FloatArray:
    return np.einsum("...x,...x->...", vectors, vectors)


def _chunks(count: int) -> Iterator[slice]:
    """Slices small enough for what is computed of them to stay in the cache."""
    return (slice(start, start + _CHUNK) for start in range(0, count, _CHUNK))


def _points_inside(corners: FloatArray, spacing_m: float) -> tuple[FloatArray, Int64Array]:
    """Points (M, 3) in the triangles (T, 3, 3) with edges longer than the spacing, and their triangles (M,)."""
    edges = np.sqrt(_squared_lengths(corners - corners[:, [1, 2, 0]])).max(axis=1, initial=0.0)
    needed = ((edges / spacing_m)[edges > spacing_m] ** 2).sum() / 2
    spacing_m *= max(np.sqrt(needed / _MAX_INNER_POINTS), 1.0)
    steps = np.ceil(edges / spacing_m).astype(np.int64)
    points, owners = [np.zeros((0, 3))], [np.zeros(0, np.int64)]
    for n in np.unique(steps[steps > 1]).tolist():
        chosen = np.flatnonzero(steps == n)
        i, j = (index.ravel() for index in np.meshgrid(np.arange(n + 1), np.arange(n + 1), indexing="ij"))
        grid = np.stack([i, j, n - i - j], axis=1)[(i + j <= n) & (np.maximum(np.maximum(i, j), n - i - j) < n)] / n
        points.append(np.einsum("gc,tcx->tgx", grid, corners[chosen]).reshape(-1, 3))
        owners.append(np.repeat(chosen, len(grid)))
    return np.concatenate(points), np.concatenate(owners)
