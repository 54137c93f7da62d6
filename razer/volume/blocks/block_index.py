"""Index of voxel blocks: their keys as one number each, kept sorted, and looked up by bisection.

It lies on the host, where block keys come from, and answers in a fixed order. Sorted by x, y and z, the blocks of a
column stand together, so that those of a box are found in time that follows the box and not the map.
"""

from __future__ import annotations

import numpy as np

from razer.arrays import BoolArray, IndexArray, Int32Array, Int64Array
from razer.errors import UnusableFrame

BITS = 21  # of each of three coordinates in a number of 64 bits: a million blocks each way from the first
REACH = 2 ** (BITS - 1)


class BlockIndex:
    """Rows of blocks by their keys."""

    def __init__(self) -> None:
        self._origin: Int32Array = np.zeros(3, np.int32)
        self._codes: Int64Array = np.zeros(0, np.int64)
        self._rows: Int64Array = np.zeros(0, np.int64)

    def __len__(self) -> int:
        return len(self._codes)

    def missing(self, block_keys: Int32Array) -> Int32Array:
        """Those of the given blocks (B, 3) that are not known, sorted, each once. Raises UnusableFrame for one that
        lies so far from the first that it has no number."""
        if len(block_keys) == 0:
            return block_keys
        if len(self) == 0:
            self._origin = block_keys[0].copy()
        if not self._is_near(block_keys).all():
            raise UnusableFrame(f"its surface lies more than {REACH} blocks from where the map began: check the pose")
        codes = np.unique(self._encode(block_keys))
        return self._decode(codes[~self._known(codes)[1]])

    def add(self, block_keys: Int32Array, rows: Int64Array) -> None:
        """Take in rows (B,) of blocks (B, 3) that are `missing`, in that order."""
        codes = self._encode(block_keys)
        places = np.searchsorted(self._codes, codes)
        self._codes, self._rows = np.insert(self._codes, places, codes), np.insert(self._rows, places, rows)

    def find(self, block_keys: Int32Array) -> Int64Array:
        """The row (B,) of each block (B, 3), -1 where it is not known."""
        if len(block_keys) == 0 or len(self) == 0:
            return np.full(len(block_keys), -1, np.int64)
        place, is_known = self._known(self._encode(block_keys))
        return np.where(is_known & self._is_near(block_keys), self._rows[place], -1)

    def all(self) -> tuple[Int32Array, Int64Array]:
        """Keys (B, 3) of all blocks, sorted, and their rows (B,)."""
        return self._decode(self._codes), self._rows

    def within(self, low: Int32Array, high: Int32Array) -> tuple[Int32Array, Int64Array]:
        """The same for the blocks of a box from `low` to `high` (3,), both included."""
        low, high = (np.clip(end.astype(np.int64) - self._origin, -REACH, REACH - 1) for end in (low, high))
        x, y = (axis.ravel() for axis in np.mgrid[low[0] : high[0] + 1, low[1] : high[1] + 1])
        starts = np.searchsorted(self._codes, _packed(x, y, low[2]))
        ends = np.searchsorted(self._codes, _packed(x, y, high[2]), side="right")
        places = _ranges(starts, ends)
        return self._decode(self._codes[places]), self._rows[places]

    def _known(self, codes: Int64Array) -> tuple[IndexArray, BoolArray]:
        place = np.searchsorted(self._codes, codes)
        place[place == len(self)] = 0
        return place, self._codes[place] == codes if len(self) else np.zeros(len(codes), bool)

    def _is_near(self, block_keys: Int32Array) -> BoolArray:
        offset = block_keys.astype(np.int64) - self._origin
        return ((offset >= -REACH) & (offset < REACH)).all(axis=1)

    def _encode(self, block_keys: Int32Array) -> Int64Array:
        x, y, z = (block_keys.astype(np.int64) - self._origin).T
        return _packed(x, y, z)

    def _decode(self, codes: Int64Array) -> Int32Array:
        mask = 2**BITS - 1
        offsets = np.stack([codes >> 2 * BITS, codes >> BITS & mask, codes & mask], axis=1) - REACH
        return (offsets + self._origin).astype(np.int32)


def _packed(x: Int64Array, y: Int64Array, z: Int64Array) -> Int64Array:
    """Numbers in the order of the offsets x, y and z from the origin."""
    return ((x + REACH) << 2 * BITS) + ((y + REACH) << BITS) + (z + REACH)


def _ranges(starts: IndexArray, ends: IndexArray) -> IndexArray:
    """All numbers from each start up to its end, one range after the other."""
    lengths = ends - starts
    first = np.repeat(starts - np.concatenate([[0], np.cumsum(lengths)[:-1]]), lengths)
    return first + np.arange(len(first))
