"""Mesh decimation by vertex clustering: vertices that share a cell of a coarser lattice become one."""

from __future__ import annotations

import numpy as np

from razer.mesh.labelled_mesh import LabelledMesh

FIRST_CELL_M = 0.03
CELL_GROWTH = 1.4


def decimated(mesh: LabelledMesh, max_vertices: int) -> LabelledMesh:
    """The mesh itself, or a clustered copy of at most `max_vertices` vertices."""
    cell_m = FIRST_CELL_M
    result = mesh
    while len(result.vertices) > max_vertices:
        result = cluster_vertices(mesh, cell_m)
        cell_m *= CELL_GROWTH
    return result


def cluster_vertices(mesh: LabelledMesh, cell_m: float) -> LabelledMesh:
    """One vertex for each occupied cell of edge `cell_m` metres: the first in the mesh's own order, with its
    colour and instance; triangles that collapse are dropped."""
    cells = np.floor(mesh.vertices / cell_m).astype(np.int64)
    _, first, owner = np.unique(cells, axis=0, return_index=True, return_inverse=True)
    triangles = owner.ravel()[mesh.triangles].astype(np.int32)
    a, b, c = triangles.T
    proper = triangles[(a != b) & (b != c) & (c != a)]
    return LabelledMesh(mesh.vertices[first], mesh.colors[first], mesh.instances[first], proper)
