"""Small surfaces to draw: plates and boxes."""

from __future__ import annotations

import numpy as np

from razer.mesh.labelled_mesh import LabelledMesh

FACES = np.array([[0, 1, 2], [0, 2, 3]], np.int32)


def plate(corner, edge_u, edge_v, instance, color=(200, 200, 200)):
    """A parallelogram that faces along edge_u x edge_v."""
    corner, edge_u, edge_v = (np.asarray(v, float) for v in (corner, edge_u, edge_v))
    vertices = np.stack([corner, corner + edge_u, corner + edge_u + edge_v, corner + edge_v])
    return LabelledMesh(
        vertices.astype(np.float32), np.full((4, 3), color, np.uint8), np.full(4, instance, np.int32), FACES
    )


def joined(*meshes):
    """One mesh of several."""
    firsts = np.cumsum([0, *(len(mesh.vertices) for mesh in meshes[:-1])])
    return LabelledMesh(
        np.concatenate([mesh.vertices for mesh in meshes]),
        np.concatenate([mesh.colors for mesh in meshes]),
        np.concatenate([mesh.instances for mesh in meshes]),
        np.concatenate([mesh.triangles + first for mesh, first in zip(meshes, firsts, strict=True)]).astype(np.int32),
    )


def box(low, high, instance, outwards=True, color=(200, 200, 200)):
    """The six sides of a box, seen from outside or, as a room, from inside."""
    low, high = np.asarray(low, float), np.asarray(high, float)
    x, y, z = np.diag(high - low)
    sides = [(low, y, x), (low, x, z), (low, z, y), (high, -x, -y), (high, -z, -x), (high, -y, -z)]
    if not outwards:
        sides = [(corner, v, u) for corner, u, v in sides]
    return joined(*(plate(corner, u, v, instance, color) for corner, u, v in sides))


def turned(mesh, rotation):
    """The same surface in another frame."""
    vertices = (mesh.vertices.astype(float) @ np.asarray(rotation).T).astype(np.float32)
    return LabelledMesh(vertices, mesh.colors, mesh.instances, mesh.triangles)
