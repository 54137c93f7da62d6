"""Gouraud shading (1971) of the light map: where faces meet at a blunt angle, light runs over the edge without a step.

A bevelled cushion or a cup of sixteen faces then looks as round as it is meant; boxes keep their edges.
"""

from __future__ import annotations

import numpy as np

from data_tools.synthetic.light.face_grid import FaceGrid
from razer.arrays import Float32Array, Float64Array, IntArray

_BLUNT_DEG = 50.0
_SAME_M = 1e-4
_MOST_AT_A_CORNER = 32


def smoothed_over_edges(
    grid: FaceGrid, quads: Float64Array, solid_of_face: IntArray, light: Float32Array
) -> Float32Array:
    """Light on the nodes where that at a corner is the mean of all faces of one solid that meet there at blunt angles.

    Args:
        grid: the nodes on F faces.
        quads: (F, 4, 3) the faces, metres.
        solid_of_face: (F,) number of the solid of each.
        light: (N, 3) on the nodes.
    """
    change = _change_at_corners(grid, quads, solid_of_face, light)
    face, cell = grid.face, grid.cell()
    on_rim = ((cell == 0) | (cell == grid.counts[face] - 1)).any(axis=1)
    node = np.flatnonzero(on_rim & (np.abs(change).max(axis=(1, 2)) > 0)[face])
    weight = _nearness(grid.points(quads)[node], quads[face[node]])
    result = light.copy()
    result[node] += np.einsum("nk,nkc->nc", weight, change[face[node]]).astype(np.float32)
    return np.maximum(result, 0)


def _nearness(points: Float64Array, corners: Float64Array) -> Float64Array:
    """How near (M, 4) each point (M, 3) is to the corners (M, 4, 3) of its face, as shares of 1."""
    size = np.ptp(corners, axis=1).max(axis=1, keepdims=True)
    weight = 1 / (np.linalg.norm(corners - points[:, None], axis=2) + 0.05 * size) ** 2
    shares: Float64Array = weight / weight.sum(axis=1, keepdims=True)
    return shares


def _change_at_corners(
    grid: FaceGrid, quads: Float64Array, solid_of_face: IntArray, light: Float32Array
) -> Float32Array:
    """By how much (F, 4, 3) light at the corners of faces differs from the mean of the faces that meet there."""
    face = np.repeat(np.arange(len(quads)), 4)
    corner = quads.reshape(-1, 3)
    own = light[grid.nearest_node(face, corner.astype(np.float32))]
    order, group = _grouped(np.column_stack([np.rint(corner / _SAME_M), solid_of_face[face]]).astype(np.int64))
    normal, value = grid.normals[face[order]], own[order].astype(np.float64)
    total, count = value.copy(), np.ones((len(order), 1))
    for step in range(1, _MOST_AT_A_CORNER):
        meets = group[step:] == group[:-step]
        if not meets.any():
            break
        blunt = (normal[step:] * normal[:-step]).sum(axis=1) > np.cos(np.radians(_BLUNT_DEG))
        first = np.flatnonzero(meets & blunt)
        for one, other in ((first, first + step), (first + step, first)):
            total[one] += value[other]
            count[one] += 1
    change = np.empty_like(value)
    change[order] = total / count - value
    return change.reshape(-1, 4, 3).astype(np.float32)


def _grouped(rows: IntArray) -> tuple[IntArray, IntArray]:
    """An order (R,) that brings equal rows together, and the group (R,) of each in that order."""
    order = np.lexsort(rows.T)
    differs = (rows[order[1:]] != rows[order[:-1]]).any(axis=1)
    return order, np.concatenate([[0], np.cumsum(differs)])
