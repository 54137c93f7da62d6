"""Duplicate detection against sums over voxels one by one, and pairs worked out by hand."""

from __future__ import annotations

from collections import Counter
from itertools import combinations

import numpy as np
import pytest

import razer.volume.blocks.block_pages
from razer.tracking.duplicates import covisibility, find_duplicates, shared_votes
from razer.volume.voxel_map import VoxelMap
from tests.support.scenes import COARSE, fill

N_VOXELS, N_IDS = 40, 9
Votes = list[dict[int, int]]


@pytest.fixture(autouse=True)
def few_blocks(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(razer.volume.blocks.block_pages, "PAGE_BLOCKS", 8)


def claimed(votes: Votes, off_surface: tuple[int, ...] = ()) -> VoxelMap:
    """A row of voxels along x with the given votes {id: count}, all of them surface but some."""
    voxels = VoxelMap(COARSE)
    voxels.admit(N_IDS)
    voxels.allocate(np.array([[0, 0, 0], [1, 0, 0], [2, 0, 0]], np.int32))
    weight = np.full((3, 4096, 1), 9.0, np.float32)
    ids, counts = np.zeros((3, 4096, 4), np.int32), np.zeros((3, 4096, 4), np.int16)
    for x in off_surface:
        weight[x // 16, x % 16] = 0.0
    for x, held in enumerate(votes):
        ids[x // 16, x % 16, : len(held)], counts[x // 16, x % 16, : len(held)] = list(held), list(held.values())
    fill(voxels, weight=weight, ids=ids, counts=counts)
    return voxels


def shares_one_by_one(votes: Votes) -> dict[tuple[int, int], float]:
    total, both = Counter[int](), Counter[tuple[int, int]]()
    for held in votes:
        total.update(held)
        for a, b in combinations(sorted(held), 2):
            both[a, b] += min(held[a], held[b])
    return {(a, b): n / min(total[a], total[b]) for (a, b), n in both.items()}


def test_shares_are_those_of_a_sum_over_voxels() -> None:
    rng = np.random.default_rng(0)
    # Any slot may hold any id, four a voxel at most, and the largest id among them.
    ids = [rng.choice(np.arange(1, N_IDS + 1), rng.integers(0, 5), replace=False) for _ in range(N_VOXELS)]
    votes: Votes = [{int(i): int(rng.integers(1, 6)) for i in held} for held in ids]
    assert shared_votes(claimed(votes)) == pytest.approx(shares_one_by_one(votes))


def test_votes_beside_the_surface_count_neither_as_shared_nor_as_own() -> None:
    votes = [{1: 2, 2: 3}, {1: 5, 2: 5}, {2: 7}]
    assert shared_votes(claimed(votes, off_surface=(1,))) == {(1, 2): 2 / 2}


def test_a_fused_track_claims_what_its_parts_did() -> None:
    voxels = claimed([{1: 2, 2: 1, 3: 4}, {2: 2, 3: 1}, {4: 3, 3: 1}])
    voxels.replace(1, 3)
    voxels.replace(4, 0)
    # 3 has 2 + 4, 1 and 1; 2 has 1 and 2.
    assert shared_votes(voxels) == {(2, 3): (1 + 1) / 3}


def test_nobody_shares_in_an_unclaimed_map() -> None:
    assert shared_votes(VoxelMap(COARSE)) == {}
    assert find_duplicates(claimed([{1: 3}, {2: 2}]), [], 0.0) == []


def test_covisibility_is_the_share_of_common_frames_among_those_of_the_one_in_fewer() -> None:
    voxels = claimed([])
    owners = [np.array(ids, np.int32) for ids in ([1, 2], [], [1, 1, 3], [2], [2, 1], [2, 4], [3])]
    pairs = [(1, 2), (1, 3), (2, 3), (1, 4), (2, 4), (5, 6)]
    assert covisibility(pairs, owners, voxels) == [2 / 3, 1 / 2, 0, 0, 1, 0]
    voxels.replace(4, 1)  # then the sixth frame shows 1 as well
    assert covisibility([(1, 2)], owners, voxels) == [3 / 4]
    assert covisibility([(1, 2)], [], voxels) == [0]


def test_duplicates_come_largest_share_first_and_need_enough_of_it() -> None:
    votes = [{1: 4, 2: 4}, {2: 4}, {3: 1, 4: 4}, {3: 3}, {5: 2, 6: 1, 7: 1}, {6: 1}, {7: 1}]
    assert shares_one_by_one(votes) == {(1, 2): 1, (3, 4): 0.25, (5, 6): 0.5, (5, 7): 0.5, (6, 7): 0.5}
    voxels = claimed(votes)
    assert find_duplicates(voxels, [], 0.5) == [(1, 2), (5, 6), (5, 7), (6, 7)]
    assert find_duplicates(voxels, [], 0.51) == [(1, 2)]
    assert find_duplicates(voxels, [], 0.25)[-1] == (3, 4)


@pytest.mark.parametrize(("n_together", "expected"), [(0, [(1, 2)]), (2, [(1, 2)]), (3, [])])
def test_two_that_are_seen_side_by_side_more_than_now_and_then_are_two(n_together: int, expected: list) -> None:
    voxels = claimed([{1: 4, 2: 4}])
    apart = [np.array([number], np.int32) for number in [1] * (10 - n_together) + [2] * 20]
    together = [np.array([2, 1], np.int32)] * n_together
    assert find_duplicates(voxels, apart + together, 0.3) == expected  # of ten frames with 1, two may show 2 as well
