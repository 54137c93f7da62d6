"""Vertex normals of a mesh, weighted by area."""

from __future__ import annotations

import numpy as np

from razer.arrays import Float64Array
from razer.volume.mesh_extraction import LabelledMesh


def vertex_normals(mesh: LabelledMesh) -> Float64Array:
    """Unit normals (V, 3): adjacent triangles' normals weighted by area; (0, 1, 0) where there are none."""
    a, b, c = (mesh.vertices[mesh.triangles[:, corner]].astype(np.float64) for corner in range(3))
    face_normals = np.cross(b - a, c - a)
    corners = mesh.triangles.reshape(-1)
    sums = np.stack(
        [np.bincount(corners, np.repeat(face_normals[:, axis], 3), len(mesh.vertices)) for axis in range(3)], axis=1
    )
    lengths = np.linalg.norm(sums, axis=1, keepdims=True)
    return np.where(lengths > 0, sums / np.where(lengths > 0, lengths, 1.0), (0.0, 1.0, 0.0))
