"""Fusion of duplicates: the surest pair first, against asking all pairs anew after every fusion."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from tests.support.cell_world import CellMask, CellWorld, rectangle

PIECES = [CellMask(rectangle(row, row + 4, column, column + 5)) for row in (0, 5, 10) for column in range(0, 36, 6)]


def world_of_torn_masks(seed: int) -> CellWorld:
    """Things that some frames show in pieces and others in masks across two or three of them."""
    rng = np.random.default_rng(seed)
    vectors = rng.normal(size=(3, 3))
    pieces = [replace(piece, embedding=tuple(vectors[rng.integers(3)])) for piece in PIECES]
    world = CellWorld()
    for _ in range(12):
        starts = np.flatnonzero(rng.random(len(pieces)) < 0.7)
        groups = np.split(np.arange(len(pieces)), starts)
        masks = [
            CellMask(frozenset().union(*(pieces[i].cells for i in g)), pieces[g[0]].embedding) for g in groups if len(g)
        ]
        world.frame(*masks, novelty=float(rng.uniform(0.3, 1)))
    return world


def fused_slowly(world: CellWorld) -> list[tuple[int, int]]:
    """The pair with the highest log-odds, asked anew each time; (gone, survivor)."""
    tracker, fused = world.tracker, []
    while True:
        best = max(
            (
                (
                    round(views + tracker._semantic_log_odds(*pair), 9),
                    sum(tracker.tracks[i].moments.count for i in pair),
                    -pair[0],
                    -pair[1],
                )
                for pair, views in tracker._consensus.candidates(-100.0)
            ),
            default=(-np.inf, 0, 0, 0),
        )
        if best[0] < tracker.config.maintenance.fuse_log_odds:
            return fused
        fused.append(tracker._fuse(-best[2], -best[3]))


@pytest.mark.parametrize("seed", range(6))
def test_the_order_of_fusions_is_that_of_asking_all_pairs_again(seed: int) -> None:
    expected = fused_slowly(world_of_torn_masks(seed))
    assert world_of_torn_masks(seed).tracker.fuse_duplicates() == expected


def test_some_fusions_follow_from_others() -> None:
    """Or else asking once would do."""
    chains = [fused_slowly(world_of_torn_masks(seed)) for seed in range(6)]
    assert any(
        {s for _, s in chain} & {g for g, _ in chain} or len({s for _, s in chain}) < len(chain) for chain in chains
    )
