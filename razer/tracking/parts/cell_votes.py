"""Votes of lattice cells for a part of a thing, sparse: how often each was in its mask, of how often it was seen.

A voxel's histogram keeps few ids and gives each vote to one of them; a cell may be of a part and of its whole."""

from __future__ import annotations

import numpy as np

from razer.arrays import BoolArray, Float32Array, Float64Array, Int64Array, IntArray
from razer.detection.observed_surface import BLOCK, Cells
from razer.volume.mesh_extraction import lattice_cubes

MAJORITY = 0.5  # share of the times a cell was seen that it has to be in the mask
_AXIS_BITS, _LOCAL_BITS = 17, 12  # of a block's coordinate and of a place in it: 63 in all
_CENTER = 1 << (_AXIS_BITS - 1)


def cell_keys(cells: Cells) -> Int64Array:
    """A number (C,) for each cell, ascending as the cells are."""
    return (_block_numbers(cells.block_keys)[cells.block] << _LOCAL_BITS) | cells.local


def lattice_keys(coordinates: IntArray) -> Int64Array:
    """The same (N,) for lattice coordinates (N, 3)."""
    x, y, z = (coordinates & (BLOCK - 1)).T
    return (_block_numbers(coordinates >> 4) << _LOCAL_BITS) | (x + BLOCK * (y + BLOCK * z))


def _block_numbers(block_keys: IntArray) -> Int64Array:
    x, y, z = block_keys.astype(np.int64).T + _CENTER
    return (((x << _AXIS_BITS) | y) << _AXIS_BITS) | z


def rows_in(sorted_keys: Int64Array, keys: Int64Array) -> tuple[Int64Array, BoolArray]:
    """Where keys (N,) stand in a sorted array, and whether they are in it at all."""
    if not len(sorted_keys):
        return np.zeros(len(keys), np.int64), np.zeros(len(keys), bool)
    rows = np.minimum(np.searchsorted(sorted_keys, keys), len(sorted_keys) - 1)
    return rows, sorted_keys[rows] == keys


def _merged(runs: Int64Array) -> Int64Array:
    """The distinct numbers of (N,) that is made of few ascending runs, which a stable sort merges."""
    numbers = np.sort(runs, kind="stable")
    return numbers[np.append(True, numbers[1:] != numbers[:-1])[: len(numbers)]]


class CellVotes:
    """keys (n,) int64 ascending, of all cells seen in blocks that masks of the part reached; votes (n,) float32,
    the views in which each was in the mask; views (n,) float32, those that showed it and the part."""

    def __init__(self) -> None:
        self.keys: Int64Array = np.zeros(0, np.int64)
        self.votes: Float32Array = np.zeros(0, np.float32)
        self.views: Float32Array = np.zeros(0, np.float32)

    @property
    def nbytes(self) -> int:
        """Bytes that they take."""
        return self.keys.nbytes + self.votes.nbytes + self.views.nbytes

    @property
    def own(self) -> Int64Array:
        """The cells that are of the part: in the mask in at least half of the views."""
        return self.keys[(self.votes > 0) & (self.votes >= MAJORITY * self.views)]

    def n_known(self, keys: Int64Array) -> int:
        """How many of some cells were seen together with the part before, in its mask or not."""
        return int(rows_in(self.keys, keys)[1].sum())

    def add(self, in_mask: Int64Array, observed: Int64Array, weight: float) -> None:
        """Take in a frame: the cells of the mask and all that it shows, both sorted, and the share of a view it is."""
        blocks = _merged(in_mask >> _LOCAL_BITS)
        self._admit(observed[rows_in(blocks, observed >> _LOCAL_BITS)[1]])
        self.votes[rows_in(self.keys, in_mask)[0]] += weight
        self.views[rows_in(observed, self.keys)[1]] += weight

    def absorb(self, other: CellVotes) -> None:
        """Add the votes of a double."""
        self._admit(other.keys)
        rows, _ = rows_in(self.keys, other.keys)
        self.votes[rows] += other.votes
        self.views[rows] += other.views

    def _admit(self, keys: Int64Array) -> None:
        merged = _merged(np.concatenate([self.keys, keys]))
        rows, _ = rows_in(merged, self.keys)
        for name in ("votes", "views"):
            grown = np.zeros(len(merged), np.float32)
            grown[rows] = getattr(self, name)
            setattr(self, name, grown)
        self.keys = merged

    def hold(self, points: Float64Array, voxel_size_m: float) -> BoolArray:
        """Which points (N, 3), metres, are of the part: the cells of the lattice cube around each add their votes,
        weighted as in trilinear interpolation."""
        corners, weight = lattice_cubes(points, voxel_size_m)
        rows, known = rows_in(self.keys, lattice_keys(corners.reshape(-1, 3)))
        weight *= known.reshape(weight.shape)
        if not len(self.keys):
            return np.zeros(len(points), bool)
        votes, views = ((weight * part[rows].reshape(weight.shape)).sum(axis=1) for part in (self.votes, self.views))
        is_held: BoolArray = (votes > 0) & (votes >= MAJORITY * views)
        return is_held

    def bounds_m(self, voxel_size_m: float) -> tuple[Float64Array, Float64Array]:
        """The corners (3,) of the blocks that the cells lie in, metres."""
        number = self.keys >> _LOCAL_BITS
        mask = (1 << _AXIS_BITS) - 1
        axes = [(number >> (_AXIS_BITS * shift)) & mask for shift in (2, 1, 0)]
        blocks = np.stack(axes, axis=1) - _CENTER
        return (blocks.min(axis=0) * BLOCK - 1) * voxel_size_m, ((blocks.max(axis=0) + 1) * BLOCK) * voxel_size_m
