"""A mesh in chunks, the cubes of a lattice, for who shows a growing map piece by piece."""

from __future__ import annotations

from collections.abc import Iterable
from typing import NamedTuple

import numpy as np

from razer.arrays import Int32Array, Int64Array
from razer.mesh.labelled_mesh import LabelledMesh


class Chunk(NamedTuple):
    """Place of a chunk on the lattice of chunks."""

    x: int
    y: int
    z: int


def blocks_of(chunks: Iterable[Chunk], blocks_per_edge: int) -> Int32Array:
    """Keys (B, 3) of the voxel blocks that chunks may hold, `blocks_per_edge` cubed of them each."""
    within = np.stack(np.meshgrid(*3 * [np.arange(blocks_per_edge)], indexing="ij"), axis=-1).reshape(-1, 3)
    corners = np.array([*chunks], np.int32).reshape(-1, 3) * blocks_per_edge
    return (corners[:, None] + within).reshape(-1, 3).astype(np.int32)


def by_chunk(mesh: LabelledMesh, edge_m: float) -> dict[Chunk, LabelledMesh]:
    """The parts of a mesh by the chunk, `edge_m` metres wide, in which the middle of each triangle lies; chunks without
    any are left out."""
    if not len(mesh.triangles):
        return {}
    middles = mesh.vertices[mesh.triangles].mean(axis=1)
    chunks, owner = np.unique(np.floor(middles / edge_m).astype(np.int64), axis=0, return_inverse=True)
    order = np.argsort(owner.ravel(), kind="stable")
    parts = np.split(order, np.cumsum(np.bincount(owner.ravel()))[:-1])
    return {Chunk(*key): _part(mesh, rows) for key, rows in zip(chunks.tolist(), parts, strict=True)}


def _part(mesh: LabelledMesh, rows: Int64Array) -> LabelledMesh:
    """Some triangles of a mesh, and their vertices."""
    used, corners = np.unique(mesh.triangles[rows], return_inverse=True)
    triangles = corners.reshape(-1, 3).astype(np.int32)
    return LabelledMesh(mesh.vertices[used], mesh.colors[used], mesh.instances[used], triangles)
