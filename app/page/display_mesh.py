"""Mesh for display: quadric decimation (Garland and Heckbert, 1997) where a map has more triangles than a page shows."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import open3d as o3d
from scipy.spatial import cKDTree

from razer.volume.mesh_extraction import LabelledMesh

MAX_TRIANGLES = 500_000


def display_mesh(mesh: LabelledMesh, max_triangles: int = MAX_TRIANGLES) -> LabelledMesh:
    """The mesh, or a decimated one of at most `max_triangles`, whose colours and instances are those of the nearest
    vertices."""
    if len(mesh.triangles) <= max_triangles:
        return mesh
    full = o3d.geometry.TriangleMesh(
        o3d.utility.Vector3dVector(mesh.vertices.astype(np.float64)), o3d.utility.Vector3iVector(mesh.triangles)
    )
    small = full.simplify_quadric_decimation(max_triangles)
    vertices = np.asarray(small.vertices).astype(np.float32)
    nearest = cKDTree(mesh.vertices).query(vertices)[1]
    triangles = np.asarray(small.triangles).astype(np.int32)
    return replace(mesh, vertices=vertices, triangles=triangles, colors=mesh.colors[nearest],
                   instances=mesh.instances[nearest])  # fmt: skip
