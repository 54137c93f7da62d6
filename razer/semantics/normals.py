"""Normals of a mesh, of its triangles and of its vertices."""

from __future__ import annotations

import numpy as np

from razer.arrays import Float64Array
from razer.mesh.labelled_mesh import LabelledMesh

TRIANGLES_AT_ONCE = 100_000


def face_normals(mesh: LabelledMesh) -> Float64Array:
    """Normals (T, 3) of the triangles, twice as long as their area; some at once, as all corners together take more
    memory than a mesh."""
    normals = np.empty(mesh.triangles.shape)
    for start in range(0, len(mesh.triangles), TRIANGLES_AT_ONCE):
        part = slice(start, start + TRIANGLES_AT_ONCE)
        a, b, c = (mesh.vertices[mesh.triangles[part, corner]].astype(np.float64) for corner in range(3))
        normals[part] = np.cross(b - a, c - a)
    return normals


def vertex_normals(mesh: LabelledMesh) -> Float64Array:
    """Unit normals (V, 3): adjacent triangles' normals weighted by area; (0, 1, 0) where there are none."""
    sums = sums_at_vertices(mesh, face_normals(mesh))
    lengths = np.linalg.norm(sums, axis=1, keepdims=True)
    return np.where(lengths > 0, sums / np.where(lengths > 0, lengths, 1.0), (0.0, 1.0, 0.0))


def sums_at_vertices(mesh: LabelledMesh, values: Float64Array) -> Float64Array:
    """The sums (V, C) of values (T, C) over the triangles around each vertex."""
    sums = np.zeros((len(mesh.vertices), values.shape[1]))
    for corners in mesh.triangles.T:
        for column in range(values.shape[1]):
            sums[:, column] += np.bincount(corners, values[:, column], len(sums))
    return sums
