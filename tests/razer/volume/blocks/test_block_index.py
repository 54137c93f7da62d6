"""The sorted index of blocks against a dictionary, and its boxes against a look at all blocks."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.testing import assert_array_equal

from razer.errors import UnusableFrame
from razer.volume.blocks.block_index import REACH, BlockIndex

FAR_OFF = np.array([0, -9_000_000, 40_000_000], np.int32)  # maps may lie anywhere, as those in survey coordinates do


def filled(seed: int) -> tuple[BlockIndex, dict[tuple[int, ...], int]]:
    """An index that was filled in six goes, and what it must hold."""
    rng = np.random.default_rng(seed)
    index, known = BlockIndex(), dict[tuple[int, ...], int]()
    for _ in range(6):
        keys = (rng.integers(-6, 7, (80, 3)) + FAR_OFF).astype(np.int32)
        missing = index.missing(keys)
        new = sorted({*map(tuple, keys.tolist())} - known.keys())
        assert_array_equal(missing, np.array(new, np.int32).reshape(-1, 3))
        rows = rng.permutation(len(new)) + len(known)
        index.add(missing, rows)
        known |= dict(zip(new, rows.tolist(), strict=True))
    return index, known


def test_rows_are_those_of_a_dictionary() -> None:
    index, known = filled(0)
    keys = np.stack(np.meshgrid(*[np.arange(-8, 9)] * 3), axis=-1).reshape(-1, 3) + FAR_OFF
    expected = [known.get(tuple(key), -1) for key in keys.tolist()]
    assert_array_equal(index.find(keys.astype(np.int32)), expected)
    assert len(index) == len(known)
    all_keys, rows = index.all()
    assert list(zip(map(tuple, all_keys.tolist()), rows.tolist(), strict=True)) == sorted(known.items())


@pytest.mark.parametrize("seed", range(5))
def test_blocks_of_a_box_are_those_that_a_look_at_all_finds(seed: int) -> None:
    index, known = filled(seed)
    rng = np.random.default_rng(seed)
    for _ in range(20):
        low, high = np.sort(rng.integers(-9, 10, (2, 3)), axis=0).astype(np.int32) + FAR_OFF
        keys, rows = index.within(low, high)
        expected = [k for k in sorted(known) if (low <= k).all() and (k <= high).all()]
        assert list(map(tuple, keys.tolist())) == expected
        assert rows.tolist() == [known[k] for k in expected]


def test_an_empty_index_knows_nothing() -> None:
    index, keys = BlockIndex(), np.array([[1, 2, 3]], np.int32)
    assert index.find(keys).tolist() == [-1]
    assert len(index.within(keys[0], keys[0])[1]) == 0
    assert len(index.find(keys[:0])) == len(index.missing(keys[:0])) == len(index.all()[0]) == 0


@pytest.mark.parametrize("axis", range(3))
@pytest.mark.parametrize("offset", [REACH, -REACH - 1])
def test_a_block_out_of_reach_is_refused_and_is_no_other(axis: int, offset: int) -> None:
    index, first = BlockIndex(), np.array([[5, 5, 5]], np.int32)
    index.add(index.missing(first), np.zeros(1, np.int64))
    far = first.copy()
    far[0, axis] += offset
    assert index.find(far).tolist() == [-1]
    with pytest.raises(UnusableFrame, match="check the pose"):
        index.missing(far)
    far[0, axis] -= np.sign(offset)
    index.add(index.missing(far), np.ones(1, np.int64))
    assert index.find(np.concatenate([far, first])).tolist() == [1, 0]
