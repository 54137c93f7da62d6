"""View consensus: fragments agree, neighbours that a bad mask joins now and then do not."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from itertools import combinations, permutations

import numpy as np
import pytest

from razer.tracking.evidence.view_consensus import MIN_VISIBLE_CELLS, ViewConsensus
from razer.tracking.label_overlap import LabelOverlap

BOUND = 1.0  # log-odds from which two tracks are fused, where the embeddings say nothing


def view(*masks: dict[int, int], visible: dict[int, int] | None = None) -> LabelOverlap:
    """One frame: cells of each track in each mask; `visible` where a track has cells outside all masks, or where masks
    share cells."""
    in_mask = {(m, track): n for m, mask in enumerate(masks) for track, n in mask.items()}
    total: dict[int, int] = {}
    for (_, track), n in in_mask.items():
        total[track] = total.get(track, 0) + n
    return LabelOverlap({}, {}, {**total, **(visible or {})}, in_mask)


TOGETHER = view({1: 50, 2: 40})
APART = view({1: 50}, {2: 40})


def consensus_of(*views: LabelOverlap, novelty: float = 1.0) -> ViewConsensus:
    consensus = ViewConsensus()
    for each in views:
        consensus.add(each, {}, novelty)
    return consensus


def agreed(consensus: ViewConsensus) -> list[tuple[int, int]]:
    """The pairs that masks alone would fuse."""
    return sorted(pair for pair, _ in consensus.candidates(BOUND))


@pytest.mark.parametrize(("together", "apart"), [(0, 1), (1, 0), (1, 1), (5, 6), (2, 38), (38, 2)])
def test_each_view_in_one_mask_is_worth_2_and_each_in_two_minus_2(together: int, apart: int) -> None:
    consensus = consensus_of(*[TOGETHER] * together, *[APART] * apart)
    assert consensus.log_odds((1, 2)) == pytest.approx(min(2.0 * (together - apart), 6.0))  # masks alone say no more


def test_fragments_under_one_mask_agree() -> None:
    assert agreed(consensus_of(TOGETHER)) == [(1, 2)]
    assert agreed(consensus_of(TOGETHER, TOGETHER)) == [(1, 2)]


def test_two_things_under_one_mask_of_stuff_are_not_one_for_that() -> None:
    """A wall's mask covers the pictures that the detector missed in this frame."""
    wall_over_both = replace(TOGETHER, stuff=frozenset({0}))
    assert consensus_of(*[wall_over_both] * 9).log_odds((1, 2)) == 0.0
    one_missed = replace(APART, stuff=frozenset({1}))
    assert consensus_of(one_missed).log_odds((1, 2)) == pytest.approx(-2.0), "one was seen without the other"


def test_a_frame_weighs_as_the_share_of_a_view_that_it_is() -> None:
    parts = consensus_of(*[TOGETHER, APART, TOGETHER] * 4, novelty=0.1)
    assert parts.log_odds((1, 2)) == pytest.approx(0.8)
    assert agreed(parts) == []


def test_a_minority_of_split_views_does_not_part_fragments() -> None:
    assert agreed(consensus_of(*[TOGETHER, TOGETHER, APART] * 5)) == [(1, 2)]


def test_neighbours_joined_in_one_view_of_twenty_do_not_agree() -> None:
    rng = np.random.default_rng(0)
    for _ in range(20):
        joined = rng.random(60) < 0.05
        joined[0] = True
        assert agreed(consensus_of(*[TOGETHER if j else APART for j in joined])) == []


def test_candidates_are_pairs_that_were_together_and_have_enough_for_it() -> None:
    for together, apart, open_pair in ((1, 2, True), (2, 3, True), (1, 3, False), (2, 38, False), (0, 1, False)):
        consensus = consensus_of(*[TOGETHER] * together, *[APART] * apart)
        expected = [((1, 2), pytest.approx(2.0 * (together - apart)))] if open_pair else []
        assert list(consensus.candidates(-2.0)) == expected


def test_the_order_of_the_views_does_not_matter() -> None:
    """Views that show two tracks apart count also before the first that shows them together."""
    views = [APART] * 38 + [TOGETHER] * 2
    assert consensus_of(*reversed(views)).log_odds((1, 2)) == consensus_of(*views).log_odds((1, 2)) == -72


def reordered(order: Sequence[int], masks: Sequence[dict[int, int]], visible: dict[int, int]) -> LabelOverlap:
    return view(*[masks[m] for m in order], visible=visible)


NESTED = {
    # A table with a lamp and a book, a mask of all, and masks of each.
    "all and each": (({1: 90, 2: 30, 3: 20}, {1: 90}, {2: 30}, {3: 20}), {(1, 2): -2.0, (1, 3): -2.0, (2, 3): -2.0}),
    # Two fragments have only the mask of both; the lamp on it has its own.
    "two in one": (({1: 50, 2: 40, 3: 30}, {1: 50, 2: 40}, {3: 30}), {(1, 2): 2.0, (1, 3): -2.0, (2, 3): -2.0}),
    # One below the other, four deep.
    "four deep": (
        ({1: 50, 2: 40, 3: 30, 4: 20}, {1: 50, 2: 40, 3: 30}, {1: 50, 2: 40}, {1: 50}),
        {(1, 2): -2.0, (1, 3): -2.0, (2, 3): -2.0, (3, 4): -2.0},
    ),
    # As large as each other: what they hold decides, and not which is first.
    "equal in size": (({1: 50, 2: 40}, {1: 50, 3: 40}), {(1, 2): 2.0, (1, 3): -2.0, (2, 3): -2.0}),
    "the same twice": (({1: 50, 2: 40}, {1: 50, 2: 40}), {(1, 2): 2.0}),
}


@pytest.mark.parametrize("name", NESTED)
def test_of_nested_masks_the_tightest_is_a_tracks_whatever_their_order(name: str) -> None:
    masks, expected = NESTED[name]
    visible = {track: max(mask.get(track, 0) for mask in masks) for mask in masks for track in mask}
    for order in permutations(range(len(masks))):
        consensus = consensus_of(reordered(order, masks, visible))
        assert {pair: consensus.log_odds(pair) for pair in expected} == expected


def test_any_overlapping_masks_say_the_same_in_any_order() -> None:
    rng = np.random.default_rng(4)
    pairs = list(combinations(range(1, 6), 2))
    decided = 0
    for _ in range(60):
        masks = [{t: int(rng.choice([20, 30, 40])) for t in range(1, 6) if rng.random() < 0.5} for _ in range(6)]
        visible = dict.fromkeys(range(1, 6), 40)
        first, other = (consensus_of(reordered(o, masks, visible)) for o in (range(6), rng.permutation(6)))
        assert [first.log_odds(p) for p in pairs] == [other.log_odds(p) for p in pairs]
        decided += sum(first.log_odds(p) != 0 for p in pairs)
    assert decided > 200


def test_a_track_hardly_in_view_says_nothing() -> None:
    few = MIN_VISIBLE_CELLS - 1
    assert agreed(consensus_of(*[view({1: 50, 2: few})] * 5)) == []
    assert agreed(consensus_of(*[view({1: 50, 2: few + 1})] * 5)) == [(1, 2)]
    # Nor does it part what others joined.
    assert consensus_of(TOGETHER, TOGETHER, *[view({1: 50}, {2: few})] * 9).log_odds((1, 2)) == 4


def test_a_mask_must_hold_half_of_a_tracks_visible_cells() -> None:
    assert agreed(consensus_of(*[view({1: 50, 2: 40}, visible={2: 81})] * 5)) == []
    assert agreed(consensus_of(*[view({1: 50, 2: 40}, visible={2: 80})] * 5)) == [(1, 2)]


def test_views_without_a_mask_on_one_of_the_two_say_nothing() -> None:
    alone = view({1: 50}, visible={2: 40})
    assert consensus_of(TOGETHER, TOGETHER, *[alone] * 20).log_odds((1, 2)) == 4


def test_fusing_renames_and_forgets() -> None:
    three = [view({1: 50, 2: 50, 3: 50})] * 3
    fused = consensus_of(*three)
    fused.replace(3, 1)
    assert dict(fused.candidates(0.0)) == {(1, 2): 6.0}  # the most that masks say
    fused.add(APART, {}, 5.0)
    assert dict(fused.candidates(0.0)) == {(1, 2): 2.0}  # three views of 2 with 1, three of 2 with 3, five against
    forgotten = consensus_of(*three)
    forgotten.replace(1, 0)
    assert dict(forgotten.candidates(0.0)) == {(2, 3): 6.0}


def test_views_apart_are_inherited_by_the_survivor() -> None:
    views = [view({1: 50}, {2: 50, 3: 50})] * 10 + [view({1: 50, 3: 50}, {2: 50})] * 3 + [view({1: 50}, {3: 50})] * 10
    consensus = consensus_of(*views)
    consensus.replace(3, 2)
    # 1 and 2 were apart in 13 views; 1 and 3 in 20, and together in 3.
    assert consensus.log_odds((1, 2)) == 2.0 * (3 - 13 - 20)
    assert agreed(consensus) == []


def test_a_track_counts_from_the_frame_it_is_born_in() -> None:
    """No voxel bears its label yet: the mask it came from speaks for it."""
    overlap = view({1: 50}, {})
    for mask_of_the_newcomer, log_odds in ((0, 2.0), (1, -2.0)):
        consensus = ViewConsensus()
        consensus.add(overlap, {2: mask_of_the_newcomer})
        assert consensus.log_odds((1, 2)) == log_odds


def test_a_track_born_in_a_second_mask_of_the_same_is_together_with_the_first() -> None:
    """Two masks of one thing: either may be the newcomer's, and what both hold of the map is the same."""
    overlap = view({1: 50}, {1: 50}, {3: 50}, visible={1: 50})
    for mask_of_the_newcomer in (0, 1):
        consensus = ViewConsensus()
        consensus.add(overlap, {2: mask_of_the_newcomer})
        assert consensus.log_odds((1, 2)) == 2
        assert consensus.log_odds((2, 3)) == -2
    # Masks that hold nothing of the map are not the same for it.
    consensus = ViewConsensus()
    consensus.add(overlap, {4: 3, 5: 4})
    assert consensus.log_odds((4, 5)) == -2


@pytest.mark.parametrize("nested", [(0, 1), (1, 0)])
def test_a_part_and_its_whole_are_one_whichever_is_listed_first(nested: tuple[int, int]) -> None:
    """Masks of a seat and of its chair, view after view; and of two things beside each other."""
    whole_and_part = replace(APART, nested=frozenset({nested}))
    assert consensus_of(whole_and_part).log_odds((1, 2)) == pytest.approx(2)
    assert agreed(consensus_of(*[whole_and_part] * 3)) == [(1, 2)]
    assert agreed(consensus_of(*[replace(APART, nested=frozenset({(0, 7)}))] * 3)) == []


@pytest.mark.parametrize(
    ("together", "apart", "others"),
    [(0, 0.4, {1: [2]}), (0, 0, {}), (0.3, 0.3, {}), (0.4, 0, {}), (0.2, 0.5, {1: [2]}), (3, 1, {}), (1, 3, {1: [2]})],
)
def test_a_track_is_held_apart_by_more_views_than_hold_it_together(
    together: float, apart: float, others: dict[int, list[int]]
) -> None:
    consensus = ViewConsensus()
    for share, each in ((together, TOGETHER), (apart, APART)):
        consensus.add(each, {}, share)
    assert consensus.apart(TOGETHER, {1: 0}) == others
    assert consensus.apart(TOGETHER, {1: 0, 2: 4}) == {}  # it has a mask of its own
    assert consensus.apart(TOGETHER, {1: 4}) == {}
    assert consensus.apart(TOGETHER, {}) == {}
