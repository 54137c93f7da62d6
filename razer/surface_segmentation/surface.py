"""Gravity-aligned surface: vertices with smooth normals, colours and the edges between them."""

from __future__ import annotations

from dataclasses import dataclass

import cv2
import numpy as np
from scipy.sparse import coo_matrix, csr_matrix, identity

from razer.arrays import Float64Array, FloatArray, Int64Array
from razer.mesh.labelled_mesh import LabelledMesh
from razer.semantics.normals import face_normals, sums_at_vertices

_SMOOTHING_ROUNDS = 3  # of normals over neighbours: beyond the noise of a voxel, below the size of a cup
_LIGHT_WEIGHT = 0.3  # of squared lightness: shading changes it more than hue
X, Y, HEIGHT = range(3)


@dataclass(frozen=True)
class Surface:
    """V vertices: positions (V, 3) metres, two level axes and the height; normals (V, 3) in the same axes, smoothed;
    lab (V, 3) colours in Lab units; areas (V,) square metres; edges (E, 2) vertex numbers, the smaller first."""

    positions: Float64Array
    normals: Float64Array
    lab: Float64Array
    areas: Float64Array
    edges: Int64Array

    @classmethod
    def of(cls, mesh: LabelledMesh, up: Float64Array) -> Surface:
        """The surface of a mesh, in a world whose upward direction is `up` (3,)."""
        edges = mesh_edges(mesh)
        around = _neighbourhood(edges, len(mesh.vertices))
        normals, areas = _normals(mesh)
        for _ in range(_SMOOTHING_ROUNDS):
            normals = unit(around @ normals)
        lab = cv2.cvtColor(mesh.colors[None].astype(np.float32) / 255, cv2.COLOR_RGB2LAB)[0].astype(np.float64)
        lab = (around @ lab) / np.asarray(around.sum(axis=1))
        level_from_world = gravity_axes(up)
        positions = mesh.vertices.astype(np.float64) @ level_from_world.T
        return cls(positions, normals @ level_from_world.T, lab, areas, edges)

    def __len__(self) -> int:
        return len(self.positions)


def gravity_axes(up: Float64Array) -> Float64Array:
    """Two level axes and `up` as the rows of a rotation (3, 3)."""
    up = unit(up)
    first = unit(np.cross(up, np.eye(3)[np.abs(up).argmin()]))
    return np.stack([first, np.cross(up, first), up])


def mesh_edges(mesh: LabelledMesh) -> Int64Array:
    """The edges (E, 2) of the triangles, each once."""
    triangles, n = mesh.triangles.astype(np.int64), len(mesh.vertices)
    sides = np.concatenate([triangles[:, [0, 1]], triangles[:, [1, 2]], triangles[:, [2, 0]]])
    keys = np.unique(sides.min(axis=1) * n + sides.max(axis=1))
    return np.stack(np.divmod(keys, max(n, 1)), axis=1)


def unit(vectors: Float64Array) -> Float64Array:
    """The vectors (..., 3) at unit length; zero stays zero."""
    return vectors / np.maximum(np.linalg.norm(vectors, axis=-1, keepdims=True), 1e-12)


def color_distance(one: FloatArray, other: FloatArray) -> Float64Array:
    """Distance of Lab colours (..., 3), with lightness counting less."""
    squares = (np.asarray(one, np.float64) - other) ** 2
    distance: Float64Array = np.sqrt(_LIGHT_WEIGHT * squares[..., 0] + squares[..., 1] + squares[..., 2])
    return distance


def _neighbourhood(edges: Int64Array, n: int) -> csr_matrix:
    """Each vertex and its neighbours as ones in a row of (n, n)."""
    one_way = coo_matrix((np.ones(len(edges)), (edges[:, 0], edges[:, 1])), (n, n)).tocsr()
    return one_way + one_way.T + identity(n, format="csr")


def _normals(mesh: LabelledMesh) -> tuple[Float64Array, Float64Array]:
    """Unit normals (V, 3) by area, and a third of the area of the triangles around each vertex (V,)."""
    faces = face_normals(mesh)
    areas = sums_at_vertices(mesh, np.linalg.norm(faces, axis=1, keepdims=True)) / 6
    return unit(sums_at_vertices(mesh, faces)), areas[:, 0]
