"""Mesh decimation by vertex clustering: vertices that share a cell of a coarser lattice become one."""

from __future__ import annotations

import numpy as np

from razer.arrays import Float32Array, Int64Array
from razer.mesh.labelled_mesh import LabelledMesh

FIRST_CELL_M = 0.03
CELL_GROWTH = 1.4
ON_SEAM = 1e-4  # of the distance between seams: rounding of float32


def decimated(mesh: LabelledMesh, max_vertices: int) -> LabelledMesh:
    """The mesh itself, or a clustered copy of at most `max_vertices` vertices."""
    cell_m = FIRST_CELL_M
    result = mesh
    while len(result.vertices) > max_vertices:
        result = cluster_vertices(mesh, cell_m)
        cell_m *= CELL_GROWTH
    return result


def cluster_vertices(mesh: LabelledMesh, cell_m: float, seams_every_m: float | None = None) -> LabelledMesh:
    """One vertex for each occupied cell of edge `cell_m` metres: that nearest to its middle, with its colour and
    instance; triangles that collapse are dropped.

    With `seams_every_m` the space is cut into cubes of that edge, and vertices on their faces are merged with such
    alone: cubes that are clustered one by one still meet in the same vertices.
    """
    cells, middles = _cells(mesh.vertices, cell_m, seams_every_m)
    _, owner, counts = np.unique(cells, axis=0, return_inverse=True, return_counts=True)
    owner = owner.ravel()
    order = np.lexsort((np.linalg.norm(mesh.vertices - middles, axis=1), owner))
    nearest = order[np.cumsum(counts) - counts]
    triangles = owner[mesh.triangles].astype(np.int32)
    a, b, c = triangles.T
    proper = triangles[(a != b) & (b != c) & (c != a)]
    return LabelledMesh(mesh.vertices[nearest], mesh.colors[nearest], mesh.instances[nearest], proper)


def _cells(vertices: Float32Array, cell_m: float, seams_every_m: float | None) -> tuple[Int64Array, Float32Array]:
    """The cell (V, 3) of each vertex (V, 3), and its middle (V, 3)."""
    if seams_every_m is None:
        cells = np.floor(vertices / cell_m).astype(np.int64)
        return cells, ((cells + 0.5) * cell_m).astype(np.float32)
    cube = np.floor(vertices / seams_every_m + ON_SEAM)
    within_m = vertices - cube * seams_every_m
    is_on_seam = within_m < ON_SEAM * seams_every_m
    cells = np.where(is_on_seam, -1, np.floor(within_m / cell_m)).astype(np.int64)
    middles = cube * seams_every_m + np.where(is_on_seam, 0.0, (cells + 0.5) * cell_m)
    per_cube = int(np.ceil(seams_every_m / cell_m)) + 2
    return cube.astype(np.int64) * per_cube + cells + 1, middles.astype(np.float32)
