"""The bounded histogram against a literal Misra-Gries loop, and what the rule promises."""

from __future__ import annotations

import numpy as np
import pytest
import torch
from hypothesis import given, settings
from hypothesis import strategies as st

from razer.volume.label_histogram import cast, merge_equal, winner, withdraw

MAX_COUNT = 30_000  # what an int16 holds, with room to add a vote


def empty(n: int, slots: int) -> tuple[torch.Tensor, torch.Tensor]:
    return torch.zeros(slots, n, dtype=torch.int32), torch.zeros(slots, n, dtype=torch.int16)


def histogram(ids: list[int], counts: list[int]) -> tuple[torch.Tensor, torch.Tensor]:
    """One voxel's histogram, as a column."""
    return torch.tensor(ids, dtype=torch.int32)[:, None], torch.tensor(counts, dtype=torch.int16)[:, None]


def cast_all(streams: np.ndarray, slots: int) -> tuple[torch.Tensor, torch.Tensor]:
    """Histograms after one vote a column, for each row of `streams` (n, T)."""
    ids, counts = empty(len(streams), slots)
    for votes in torch.from_numpy(streams.astype(np.int32)).T:
        ids, counts = cast(ids, counts, votes)
    return ids, counts


def as_dicts(ids: torch.Tensor, counts: torch.Tensor) -> list[dict[int, int]]:
    """What each voxel holds."""
    return [
        {i: c for i, c in zip(row, many, strict=True) if c}
        for row, many in zip(ids.T.tolist(), counts.T.tolist(), strict=True)
    ]


def slow_misra_gries(stream: list[int], slots: int) -> dict[int, int]:
    held: dict[int, int] = {}
    for vote in stream:
        if vote == 0:
            continue
        if vote in held or len(held) < slots:
            held[vote] = held.get(vote, 0) + 1
        else:
            held = {i: n - 1 for i, n in held.items() if n > 1}
    return held


STREAMS = st.integers(1, 30).flatmap(
    lambda length: st.lists(st.lists(st.integers(0, 5), min_size=length, max_size=length), min_size=1, max_size=5)
)


@given(streams=STREAMS, slots=st.integers(1, 4))
@settings(deadline=None, max_examples=80)
def test_histograms_follow_the_literal_rule(streams: list[list[int]], slots: int) -> None:
    ids, counts = cast_all(np.array(streams), slots)
    assert as_dicts(ids, counts) == [slow_misra_gries(stream, slots) for stream in streams]
    assert ((ids > 0) == (counts > 0)).all()


@pytest.mark.parametrize("slots", [1, 2, 4])
def test_whoever_has_more_than_one_share_in_k_plus_one_survives(slots: int) -> None:
    rng = np.random.default_rng(slots)
    length = 60
    winning = length // (slots + 1) + 1
    streams = np.stack(
        [rng.permutation(np.r_[np.full(winning, 7), rng.integers(8, 30, length - winning)]) for _ in range(300)]
    )
    ids, _ = cast_all(streams, slots)
    assert (ids == 7).any(dim=0).all()


def test_counts_are_low_by_at_most_the_votes_over_k_plus_one() -> None:
    rng = np.random.default_rng(5)
    streams = rng.integers(1, 9, (100, 80))
    for stream, held in zip(streams, as_dicts(*cast_all(streams, 3)), strict=True):
        for label in range(1, 9):
            true = int((stream == label).sum())
            assert true - 80 // 4 <= held.get(label, 0) <= true


def test_a_late_right_label_wins() -> None:
    early = [label for label in (1, 2, 3, 4) for _ in range(5)]  # all four slots are taken
    ids, counts = cast_all(np.array([early + [9] * 12]), 4)
    assert winner(ids, counts).tolist() == [9]


def test_counts_stop_at_their_limit() -> None:
    ids, counts = histogram([3, 0], [MAX_COUNT, 0])
    for _ in range(3):
        ids, counts = cast(ids, counts, torch.tensor([3], dtype=torch.int32))
    assert as_dicts(ids, counts) == [{3: MAX_COUNT}]


def test_a_full_histogram_gives_up_a_vote_each_and_the_newcomer_gets_none() -> None:
    ids, counts = cast(*histogram([3, 4], [2, 1]), torch.tensor([7], dtype=torch.int32))
    assert ids[:, 0].tolist() == [3, 0]
    assert counts[:, 0].tolist() == [1, 0]


def test_cast_leaves_its_input_alone() -> None:
    ids, counts = empty(2, 2)
    cast(ids, counts, torch.tensor([1, 2], dtype=torch.int32))
    assert not ids.any()
    assert not counts.any()


@given(
    slots=st.lists(
        st.lists(st.tuples(st.integers(0, 4), st.integers(0, 9)), min_size=4, max_size=4), min_size=1, max_size=6
    )
)
@settings(deadline=None, max_examples=60)
def test_merge_adds_up_what_names_the_same(slots: list[list[tuple[int, int]]]) -> None:
    table = torch.tensor(slots)
    ids, counts = table[..., 0].T.int(), table[..., 1].T.short()
    new_ids, new_counts = merge_equal(ids.clone(), counts.clone())
    for row, held in zip(slots, as_dicts(new_ids, new_counts), strict=True):
        expected = {i: sum(n for j, n in row if j == i) for i, _ in row if i > 0}
        assert held == {i: n for i, n in expected.items() if n}
    named = [[i for i in row if i] for row in new_ids.T.tolist()]
    assert all(len(row) == len(set(row)) for row in named)


def test_merge_of_two_large_counts_stops_at_the_limit() -> None:
    assert as_dicts(*merge_equal(*histogram([3, 3], [20_000, 20_000]))) == [{3: MAX_COUNT}]


def test_counts_stop_at_their_limit_one_vote_after_the_other() -> None:
    ids, counts = histogram([3], [MAX_COUNT - 1])
    for _ in range(2):
        ids, counts = cast(ids, counts, torch.tensor([3], dtype=torch.int32))
    assert as_dicts(ids, counts) == [{3: MAX_COUNT}]


def test_a_slot_that_lost_its_last_vote_names_nobody_and_none_goes_below_zero() -> None:
    ids, counts = histogram([5, 2, 9, 0], [1, 4, 1, 0])
    lost = torch.tensor([True, True, False, True])[:, None]
    fewer_ids, fewer = withdraw(ids, counts, lost)
    assert fewer_ids[:, 0].tolist() == [0, 2, 9, 0]
    assert fewer[:, 0].tolist() == [0, 3, 1, 0]
    assert counts[:, 0].tolist() == [1, 4, 1, 0]


@pytest.mark.parametrize(
    ("ids", "counts", "expected"),
    [
        ([5, 2, 9, 0], [1, 4, 3, 0], 2),
        ([5, 2, 9, 0], [4, 4, 3, 0], 2),  # of equal counts the lowest id
        ([5, 2, 9, 1], [4, 4, 4, 4], 1),
        ([0, 0, 0, 0], [0, 0, 0, 0], 0),
        ([7, 3, 0, 0], [0, 1, 0, 0], 3),  # a slot without votes names nobody
    ],
)
def test_winner_has_the_most_votes(ids: list[int], counts: list[int], expected: int) -> None:
    label = winner(*histogram(ids, counts))
    assert label.tolist() == [expected]
    assert label.dtype == torch.int32
