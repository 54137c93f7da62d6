"""Tracks that are parts of others by the masks of all views are fused at the end, unless they look unlike them."""

from __future__ import annotations

import pytest

from razer.config import MapperConfig
from razer.tracking.evidence.view_consensus import MAX_MASK_LOG_ODDS, nested_log_odds
from tests.support.cell_world import CellMask, CellWorld, rectangle


def world_of_three(stuff: str | None = None, **maintenance: object) -> CellWorld:
    """Tracks 1 (a chair), 2 (its seat, which looks the same) and 3 (a cushion, which does not), over four views."""
    world = CellWorld(MapperConfig.model_validate({"maintenance": maintenance}))
    masks = (
        CellMask(rectangle(0, 8, 0, 10)),
        CellMask(rectangle(12, 18, 0, 6)),
        CellMask(rectangle(12, 18, 20, 30), (0, 1)),
    )
    for _ in range(4):
        world.frame(masks[0], CellMask(masks[1].cells, stuff=stuff), masks[2])
    return world


@pytest.mark.parametrize(
    ("pairs", "fused"),
    [
        ([(2, 1, 4.0)], [(2, 1)]),
        ([(2, 1, 0.5)], [(2, 1)]),  # their looks say the rest
        ([(3, 1, 6.0)], []),  # nothing like it
        ([(2, 1, 4.0), (2, 1, 2.0)], [(2, 1)]),
        ([(9, 1, 6.0), (1, 1, 6.0)], []),  # pruned since; itself
    ],
)
def test_parts_are_fused_by_masks_and_looks(pairs: list[tuple[int, int, float]], fused: list[tuple[int, int]]) -> None:
    world = world_of_three()
    assert world.tracker.fuse_parts(pairs) == fused
    assert set(world.tracker.tracks) == {1, 2, 3} - {gone for gone, _ in fused}


def test_a_part_of_what_was_fused_goes_where_that_went() -> None:
    world = world_of_three()
    world.tracker.tracks[3].bank = world.tracker.tracks[1].bank
    assert world.tracker.fuse_parts([(2, 1, 5.0), (3, 2, 4.0)]) == [(2, 1), (3, 1)]


def test_stuff_is_no_part_and_without_fusion_nothing_is() -> None:
    assert world_of_three("wall").tracker.fuse_parts([(2, 1, 6.0)]) == []
    assert world_of_three(fuse_duplicates=False).tracker.fuse_parts([(2, 1, 6.0)]) == []


def test_views_of_one_within_the_other_weigh_as_those_of_both_beside_each_other() -> None:
    assert nested_log_odds(2, 2) == 0
    assert nested_log_odds(2, 1) == -nested_log_odds(1, 2) == pytest.approx(2)
    assert nested_log_odds(0.5, 0.25) == pytest.approx(0.5)  # views that repeat another count for less than one
    assert nested_log_odds(3, 1.5) == pytest.approx(3)
    assert nested_log_odds(100, 0) == MAX_MASK_LOG_ODDS
