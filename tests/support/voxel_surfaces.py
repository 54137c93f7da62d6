"""Surfaces of solids made of cubes, closed and with shared vertices as marching cubes leaves them."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from razer.mesh.labelled_mesh import LabelledMesh

QUAD = np.array([[0, 0], [1, 0], [1, 1], [0, 1]])


def voxel_surface(solids: np.ndarray, colors: Mapping[int, tuple[int, int, int]], size_m: float = 0.02) -> LabelledMesh:
    """The surface between the solids of a grid (X, Y, Z), by number, and what is empty (0); vertices bear the number
    and the colour of a solid that they touch. What the grid's own border cuts is open."""
    quads, owners = [], []
    for axis in range(3):
        low, high = np.moveaxis(solids, axis, 0)[:-1], np.moveaxis(solids, axis, 0)[1:]
        for inner, outer, is_upper in ((low, high, True), (high, low, False)):
            at = np.argwhere((inner > 0) & (outer == 0))
            corners = np.repeat(at[:, None], 4, axis=1)
            corners[..., 0] += 1
            corners[..., 1:] += QUAD if is_upper else QUAD[::-1]
            if axis == 1:  # moving the second axis to the front turns the handedness
                corners = corners[:, ::-1]
            quads.append(corners[..., np.argsort([axis, *(a for a in range(3) if a != axis)])])
            owners.append(inner[tuple(at.T)])
    corners, owner = np.concatenate(quads), np.concatenate(owners)
    vertices, index = np.unique(corners.reshape(-1, 3), axis=0, return_inverse=True)
    index = index.reshape(-1, 4)
    instances = np.zeros(len(vertices), np.int32)
    np.maximum.at(instances, index.ravel(), np.repeat(owner, 4).astype(np.int32))
    table = np.array([colors.get(number, (128, 128, 128)) for number in range(int(solids.max()) + 1)], np.uint8)
    triangles = np.concatenate([index[:, [0, 1, 2]], index[:, [0, 2, 3]]]).astype(np.int32)
    return LabelledMesh((vertices * size_m).astype(np.float32), table[instances], instances, triangles)
