"""Chunks of 4^3 blocks of the map, each logged again only when it has been observed much more often.

A chunk observed n times is logged about log(n) times, which keeps the timeline small and logging cheap.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from razer.arrays import Int32Array, Int64Array
from razer.detection.observed_surface import BLOCK
from razer.mesh.labelled_mesh import LabelledMesh

BLOCKS_PER_EDGE = 4
_WITHIN = np.stack(np.meshgrid(*3 * [np.arange(BLOCKS_PER_EDGE)], indexing="ij"), axis=-1).reshape(-1, 3)


class Chunk(NamedTuple):
    """Place of a chunk on the lattice of chunks."""

    x: int
    y: int
    z: int

    @property
    def block_keys(self) -> Int32Array:
        """Keys (64, 3) of the blocks it may hold."""
        return (np.array(self) * BLOCKS_PER_EDGE + _WITHIN).astype(np.int32)


class ChunkSchedule:
    """Counts how often each chunk's blocks were observed, and which chunks are due to be logged."""

    def __init__(self, growth: float) -> None:
        self._growth = growth
        self._observations: dict[Chunk, int] = {}
        self._logged: dict[Chunk, int] = {}

    def observe(self, block_keys: Int32Array) -> None:
        """Take in the keys (M, 3) of the blocks that one frame changed."""
        chunks, counts = np.unique(block_keys // BLOCKS_PER_EDGE, axis=0, return_counts=True)
        for key, count in zip(chunks.tolist(), counts.tolist(), strict=True):
            chunk = Chunk(*key)
            self._observations[chunk] = self._observations.get(chunk, 0) + count

    def take_due(self) -> list[Chunk]:
        """The chunks observed `growth` times as often as when last taken; they count as logged from now on."""
        due = [c for c, n in self._observations.items() if n >= self._growth * self._logged.get(c, 0)]
        self._logged.update((chunk, self._observations[chunk]) for chunk in due)
        return due

    def invalidate(self) -> None:
        """All chunks are due again, since the whole map moved."""
        self._logged = dict.fromkeys(self._logged, 0)


def by_chunk(mesh: LabelledMesh, voxel_size_m: float) -> dict[Chunk, LabelledMesh]:
    """The parts of a mesh by the chunk in which the middle of each triangle lies; chunks without any are left out."""
    if not len(mesh.triangles):
        return {}
    middles = mesh.vertices[mesh.triangles].mean(axis=1)
    edge_m = BLOCK * BLOCKS_PER_EDGE * voxel_size_m
    chunks, owner = np.unique(np.floor(middles / edge_m).astype(np.int64), axis=0, return_inverse=True)
    order = np.argsort(owner.ravel(), kind="stable")
    parts = np.split(order, np.cumsum(np.bincount(owner.ravel()))[:-1])
    return {Chunk(*key): _part(mesh, rows) for key, rows in zip(chunks.tolist(), parts, strict=True)}


def _part(mesh: LabelledMesh, rows: Int64Array) -> LabelledMesh:
    """Some triangles of a mesh, and their vertices."""
    used, corners = np.unique(mesh.triangles[rows], return_inverse=True)
    triangles = corners.reshape(-1, 3).astype(np.int32)
    return LabelledMesh(mesh.vertices[used], mesh.colors[used], mesh.instances[used], triangles)
