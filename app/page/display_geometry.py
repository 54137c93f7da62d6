"""Geometry of a map for display: decimated where it has more triangles than a page shows, with ambient occlusion.

Edits by hand change whose the vertices are, not where they lie, so that the last geometry is kept for the next page.
"""

from __future__ import annotations

from collections import OrderedDict
from dataclasses import dataclass
from hashlib import blake2b

import numpy as np
import open3d as o3d
from scipy.spatial import cKDTree

from app.page.ambient_occlusion import ambient_occlusion
from app.page.traversal import Traversal, traverse
from razer.arrays import Float32Array, Int32Array, IntArray, Uint8Array
from razer.mesh.labelled_mesh import LabelledMesh

MAX_TRIANGLES = 500_000
_KEPT = 2  # a map, and the same place with other poses


@dataclass(frozen=True)
class DisplayGeometry:
    """vertices (V, 3) metres, triangles (T, 3), rows (V,): the vertex of the map whose colour and instance each has,
    occlusion (V,): 255 = open, and the order in which the triangles are written."""

    vertices: Float32Array
    triangles: Int32Array
    rows: IntArray
    occlusion: Uint8Array
    order: Traversal

    def mesh(self, full: LabelledMesh) -> LabelledMesh:
        """The labelled mesh that is shown of a full one of this geometry."""
        return LabelledMesh(self.vertices, full.colors[self.rows], full.instances[self.rows], self.triangles)


_last: OrderedDict[tuple[bytes, int], DisplayGeometry] = OrderedDict()


def display_geometry(mesh: LabelledMesh, max_triangles: int = MAX_TRIANGLES) -> DisplayGeometry:
    """The geometry of a mesh, of at most about `max_triangles` triangles (Garland and Heckbert, 1997)."""
    digest = blake2b(mesh.vertices.tobytes())
    digest.update(mesh.triangles.tobytes())
    key = digest.digest(), max_triangles
    if key not in _last:
        _last[key] = _made(mesh, max_triangles)
        while len(_last) > _KEPT:
            _last.popitem(last=False)
    return _last[key]


def _made(mesh: LabelledMesh, max_triangles: int) -> DisplayGeometry:
    vertices, triangles, rows = mesh.vertices, mesh.triangles, np.arange(len(mesh.vertices))
    if len(triangles) > max_triangles:
        vertices, triangles = _decimated(mesh, max_triangles)
        rows = cKDTree(mesh.vertices).query(vertices)[1]
    shown = LabelledMesh(vertices, mesh.colors[rows], mesh.instances[rows], triangles)
    return DisplayGeometry(vertices, triangles, rows, ambient_occlusion(shown), traverse(triangles))


def _decimated(mesh: LabelledMesh, max_triangles: int) -> tuple[Float32Array, Int32Array]:
    full = o3d.geometry.TriangleMesh(
        o3d.utility.Vector3dVector(mesh.vertices.astype(np.float64)), o3d.utility.Vector3iVector(mesh.triangles)
    )
    small = full.simplify_quadric_decimation(max_triangles)
    return np.asarray(small.vertices).astype(np.float32), np.asarray(small.triangles).astype(np.int32)
