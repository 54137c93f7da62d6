"""Chunks of 2^3 blocks of a growing map, and which of them are shown most out of date."""

from __future__ import annotations

from collections.abc import Iterable
from typing import NamedTuple

import numpy as np

from razer.arrays import Int32Array, Int64Array
from razer.detection.observed_surface import BLOCK
from razer.mesh.labelled_mesh import LabelledMesh

BLOCKS_PER_EDGE = 2
_LOWER = np.stack(np.meshgrid(*3 * [[0, -1]], indexing="ij"), axis=-1).reshape(-1, 3)
_WITHIN = np.stack(np.meshgrid(*3 * [np.arange(BLOCKS_PER_EDGE)], indexing="ij"), axis=-1).reshape(-1, 3)


class Chunk(NamedTuple):
    """Place of a chunk on the lattice of chunks."""

    x: int
    y: int
    z: int


class DueChunks:
    """Counts how often each chunk changed, in all and since it was taken last."""

    def __init__(self) -> None:
        self._changes: dict[Chunk, int] = {}
        self._taken: dict[Chunk, int] = {}

    def __len__(self) -> int:
        """How many have changed since they were taken."""
        return sum(n > self._taken.get(chunk, 0) for chunk, n in self._changes.items())

    def observe(self, block_keys: Int32Array) -> None:
        """Take in the keys (M, 3) of blocks that changed: cubes that reach them from lower blocks change, too."""
        reached = np.unique((block_keys[:, None] + _LOWER).reshape(-1, 3) // BLOCKS_PER_EDGE, axis=0)
        for key in reached.tolist():
            chunk = Chunk(*key)
            self._changes[chunk] = self._changes.get(chunk, 0) + 1

    def all_changed(self) -> None:
        """The whole map was replaced: every chunk counts as never taken."""
        self._taken.clear()

    def take(self, most: int) -> list[Chunk]:
        """Those that changed most, by the share of their changes since they were taken last."""
        share = {c: (n - self._taken.get(c, 0)) / n for c, n in self._changes.items()}
        due = sorted((c for c in share if share[c] > 0), key=lambda c: (-share[c], c))[:most]
        self._taken.update((chunk, self._changes[chunk]) for chunk in due)
        return due


def blocks_of(chunks: Iterable[Chunk]) -> Int32Array:
    """Keys (B, 3) of the blocks that chunks may hold."""
    corners = np.array([*chunks], np.int32).reshape(-1, 3) * BLOCKS_PER_EDGE
    return (corners[:, None] + _WITHIN).reshape(-1, 3).astype(np.int32)


def split(mesh: LabelledMesh, chunks: Iterable[Chunk], voxel_size_m: float) -> dict[Chunk, LabelledMesh]:
    """The mesh of each chunk, perhaps empty: each triangle lies in the lattice cube that it came from."""
    centers = mesh.vertices[mesh.triangles].mean(axis=1) if len(mesh.triangles) else np.zeros((0, 3), np.float32)
    places = np.floor(centers / (voxel_size_m * BLOCK * BLOCKS_PER_EDGE)).astype(np.int64)
    keys, owner = np.unique(places, axis=0, return_inverse=True)
    row_of = {Chunk(*key): row for row, key in enumerate(keys.tolist())}
    owner = owner.reshape(-1)
    none = np.zeros(0, np.int64)
    return {c: _rows(mesh, np.flatnonzero(owner == row_of[c]) if c in row_of else none) for c in chunks}


def _rows(mesh: LabelledMesh, triangles: Int64Array) -> LabelledMesh:
    vertices, corners = np.unique(mesh.triangles[triangles], return_inverse=True)
    return LabelledMesh(
        mesh.vertices[vertices],
        mesh.colors[vertices],
        mesh.instances[vertices],
        corners.reshape(-1, 3).astype(np.int32),
    )
