"""Counts of pairs against a dictionary that is searched as a whole."""

from __future__ import annotations

import numpy as np

from razer.tracking.evidence.pair_counts import Pair, PairCounts


def slow_replace(counts: dict[Pair, float], gone: int, survivor: int) -> None:
    for pair in [p for p in counts if gone in p]:
        n = counts.pop(pair)
        other = pair[0] if pair[1] == gone else pair[1]
        if survivor and other != survivor:
            new = min(other, survivor), max(other, survivor)
            counts[new] = counts.get(new, 0) + n


def test_fused_and_forgotten_tracks_leave_what_a_search_of_all_pairs_leaves() -> None:
    rng = np.random.default_rng(0)
    counts, slow = PairCounts(), dict[Pair, float]()
    for step in range(600):
        a, b = (int(i) for i in np.sort(rng.choice(np.arange(1, 30), 2, replace=False)))
        counts[a, b] += 1
        slow[a, b] = slow.get((a, b), 0) + 1
        if step % 5 == 0:
            gone, survivor = (int(i) for i in rng.choice(np.arange(1, 30), 2, replace=False))
            survivor *= step % 10 > 0
            counts.replace(gone, survivor)
            slow_replace(slow, gone, survivor)
        assert counts == slow
    assert len(slow) > 50


def test_a_fusion_looks_at_the_pairs_of_its_track_only() -> None:
    counts = PairCounts()
    for i in range(1, 500):
        counts[i, i + 1] += 1
    counts[3, 100] += 2
    looked_at = []
    counts.pop = lambda pair: looked_at.append(pair) or dict.pop(counts, pair)  # type: ignore[method-assign]
    counts.replace(3, 700)
    assert sorted(looked_at) == [(2, 3), (3, 4), (3, 100)]
    assert counts[100, 700] == 2


def test_pairs_never_counted_are_zero_and_stay_out() -> None:
    counts = PairCounts()
    assert counts[1, 2] == 0
    assert not counts
