"""View consensus: fragments agree, neighbours that a bad mask joins now and then do not."""

from __future__ import annotations

import numpy as np

from razer.tracking.label_overlap import LabelOverlap
from razer.tracking.view_consensus import MIN_VISIBLE_CELLS, ViewConsensus

FRAMES, SHARE = 2, 0.6


def view(*masks: dict[int, int], visible: dict[int, int] | None = None) -> LabelOverlap:
    """One frame: cells of each track in each mask; `visible` where a track has cells outside all masks."""
    in_mask = {(m, track): n for m, mask in enumerate(masks) for track, n in mask.items()}
    total: dict[int, int] = {}
    for (_, track), n in in_mask.items():
        total[track] = total.get(track, 0) + n
    return LabelOverlap({}, {}, {**total, **(visible or {})}, in_mask)


TOGETHER = view({1: 50, 2: 40})
APART = view({1: 50}, {2: 40})


def agreed(*views: LabelOverlap) -> list[tuple[int, int]]:
    consensus = ViewConsensus()
    for each in views:
        consensus.add(each, {})
    return consensus.agreed(FRAMES, SHARE)


def test_fragments_under_one_mask_agree() -> None:
    assert agreed(TOGETHER, TOGETHER) == [(1, 2)]


def test_one_frame_is_not_enough() -> None:
    assert agreed(TOGETHER) == []


def test_a_minority_of_split_views_does_not_part_fragments() -> None:
    assert agreed(*[TOGETHER, TOGETHER, APART] * 5) == [(1, 2)]


def test_neighbours_joined_in_one_view_of_twenty_do_not_agree() -> None:
    rng = np.random.default_rng(0)
    for _ in range(20):
        joined = rng.random(60) < 0.05
        joined[0] = True
        assert agreed(*[TOGETHER if j else APART for j in joined]) == []


def test_a_piece_seen_together_now_and_then_is_given_the_benefit_of_the_doubt() -> None:
    """Five frames of a split and five frames together: a piece; two together of forty: a neighbour."""
    for together, apart, fused in ((5, 6, True), (2, 2, True), (2, 38, False), (0, 1, False)):
        consensus = ViewConsensus()
        for each in [TOGETHER] * together + [APART] * apart:
            consensus.add(each, {})
        assert consensus.agreed(2, 0.6, prior=4.0) == ([(1, 2)] if fused else [])


def test_the_order_of_the_views_does_not_matter() -> None:
    """Views that show two tracks apart count also before the first that shows them together."""
    views = [APART] * 38 + [TOGETHER] * 2
    assert agreed(*reversed(views)) == []
    assert agreed(*views) == []


def test_a_track_hardly_in_view_says_nothing() -> None:
    few = MIN_VISIBLE_CELLS - 1
    assert agreed(*[view({1: 50, 2: few})] * 5) == []
    assert agreed(*[view({1: 50, 2: few + 1})] * 5) == [(1, 2)]
    # Nor does it part what others joined.
    assert agreed(TOGETHER, TOGETHER, *[view({1: 50}, {2: few})] * 9) == [(1, 2)]


def test_a_mask_must_hold_half_of_a_tracks_visible_cells() -> None:
    assert agreed(*[view({1: 50, 2: 40}, visible={2: 90})] * 5) == []
    assert agreed(*[view({1: 50, 2: 40}, visible={2: 80})] * 5) == [(1, 2)]


def test_views_without_a_mask_on_one_of_the_two_say_nothing() -> None:
    alone = view({1: 50}, visible={2: 40})
    assert agreed(TOGETHER, TOGETHER, *[alone] * 20) == [(1, 2)]


def test_the_surest_pair_comes_first() -> None:
    both = view({1: 50, 2: 50}, {3: 50, 4: 50})
    assert agreed(both, both, view({3: 50, 4: 50})) == [(3, 4), (1, 2)]


def consensus_of_three() -> ViewConsensus:
    consensus = ViewConsensus()
    for _ in range(3):
        consensus.add(view({1: 50, 2: 50, 3: 50}), {})
    return consensus


def test_fusing_renames_and_forgets() -> None:
    fused = consensus_of_three()
    fused.replace(3, 1)
    assert fused.agreed(FRAMES, SHARE) == [(1, 2)]
    forgotten = consensus_of_three()
    forgotten.replace(1, 0)
    assert forgotten.agreed(FRAMES, SHARE) == [(2, 3)]


def test_views_apart_are_inherited_by_the_survivor() -> None:
    consensus = ViewConsensus()
    for each in [view({1: 50}, {2: 50, 3: 50})] * 10 + [view({1: 50, 3: 50}, {2: 50})] * 3:
        consensus.add(each, {})
    for each in [view({1: 50}, {3: 50})] * 10:
        consensus.add(each, {})
    consensus.replace(3, 2)
    assert consensus.agreed(FRAMES, SHARE) == []


def test_a_track_counts_from_the_frame_it_is_born_in() -> None:
    """No voxel bears its label yet: the mask it came from speaks for it."""
    overlap = view({1: 50}, {})
    for mask_of_the_newcomer, found in ((0, [(1, 2)]), (1, [])):
        consensus = ViewConsensus()
        for _ in range(2):
            consensus.add(overlap, {2: mask_of_the_newcomer})
        assert consensus.agreed(FRAMES, SHARE) == found
    parted = ViewConsensus()
    for _ in range(3):
        parted.add(overlap, {2: 1})
    for _ in range(2):
        parted.add(TOGETHER, {})
    assert parted.agreed(FRAMES, SHARE) == []
