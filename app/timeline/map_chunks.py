"""Chunks of 4^3 blocks of the map, each logged again only when it has been observed much more often.

A chunk observed n times is logged about log(n) times, which keeps the timeline small and logging cheap.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from razer.arrays import Int32Array, Int64Array
from razer.detection.observed_surface import BLOCK
from razer.volume.mesh_extraction import SurfacePoints

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


def thinned(points: SurfacePoints, voxel_size_m: float, keep_one_of: int) -> SurfacePoints:
    """A fixed pseudo-random choice of the voxels: a voxel that is kept stays kept whenever it is logged again."""
    if keep_one_of == 1:
        return points
    lattice = np.rint(points.positions / voxel_size_m).astype(np.int64)
    keep = _hashed(lattice) % keep_one_of == 0
    return SurfacePoints(points.positions[keep], points.colors[keep], points.instances[keep])


def by_chunk(points: SurfacePoints, voxel_size_m: float) -> dict[Chunk, Int64Array]:
    """Indices of the points that lie in each chunk; chunks without points are left out."""
    lattice = np.rint(points.positions / voxel_size_m).astype(np.int64)
    chunks, owner, counts = np.unique(
        lattice // (BLOCK * BLOCKS_PER_EDGE), axis=0, return_inverse=True, return_counts=True
    )
    order = np.argsort(owner.ravel(), kind="stable")
    ends = np.cumsum(counts)
    return {Chunk(*key): order[end - n : end] for key, end, n in zip(chunks.tolist(), ends, counts, strict=True)}


def _hashed(lattice: Int64Array) -> NDArray[np.uint64]:
    """Well mixed numbers (N,) of lattice coordinates (N, 3), by half of SplitMix64's finaliser."""
    mixed = lattice.astype(np.uint64) @ np.array(
        [0x9E3779B97F4A7C15, 0xC2B2AE3D27D4EB4F, 0x165667B19E3779F9], np.uint64
    )
    mixed = (mixed ^ (mixed >> np.uint64(30))) * np.uint64(0xBF58476D1CE4E5B9)
    return mixed ^ (mixed >> np.uint64(31))
