"""The order of masks: nested and overlapping masks of a frame make the same map in any order."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import pytest

from tests.support.cell_world import CellMask, CellWorld, rectangle


def history_by_content(frames: Sequence[Sequence[CellMask]], rng: np.random.Generator | None) -> list[object]:
    """What happened in each frame; a track is named by the frames and masks that it and its duplicates were born of."""
    world, history = CellWorld(), []
    names: dict[int, frozenset[tuple[int, CellMask]]] = {}
    for i, masks in enumerate(frames):
        shuffled = [masks[m] for m in (range(len(masks)) if rng is None else rng.permutation(len(masks)))]
        decisions = world.frame(*shuffled)
        by_mask = list(zip(decisions, shuffled, strict=True))
        names |= {d.track_id: frozenset([(i, mask)]) for d, mask in by_mask if d.outcome == "born"}
        decided = {(mask, d.outcome, names[d.track_id]) for d, mask in by_mask}
        fused = set()
        for gone, survivor in world.fuse():
            names[survivor] |= names[gone]
            fused.add(names[survivor])
        pruned = {names[gone] for gone in world.prune()}
        history.append((decided, fused, pruned, {world.owned(t) for t in world.tracker.tracks}))
    return history


def nested_frames(seed: int) -> list[tuple[CellMask, ...]]:
    """Masks of a table, of all on it, of a lamp, its shade, a tray and the cup in it, each now and then; some torn."""
    rng = np.random.default_rng(seed)
    shapes = {
        (0, 10, 0, 20): 0, (0, 10, 0, 21): 0, (0, 10, 0, 9): 0, (0, 10, 9, 20): 0,
        (2, 8, 2, 8): 1, (2, 5, 2, 8): 1, (2, 9, 10, 17): 2, (3, 6, 11, 14): 3, (12, 18, 25, 35): 4,
    }  # fmt: skip
    frames = []
    for _ in range(10):
        chosen = [(shape, thing) for shape, thing in shapes.items() if rng.random() < 0.6]
        frames.append(
            tuple(
                CellMask(
                    rectangle(*shape), tuple(np.eye(6)[thing] + rng.normal(0, 0.15, 6)), float(rng.uniform(0.4, 1))
                )
                for shape, thing in chosen
            )
        )
    return frames


@pytest.mark.parametrize("seed", range(5))
def test_nested_masks_in_any_order_make_the_same_map(seed: int) -> None:
    frames = nested_frames(seed)
    expected = history_by_content(frames, None)
    for shuffle in range(3):
        assert history_by_content(frames, np.random.default_rng(shuffle)) == expected
