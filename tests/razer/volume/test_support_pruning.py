"""Pruning by support: who is unmatched in view, whose box is hollow, for how long, and who is spared."""

from __future__ import annotations

import numpy as np
import pytest

from razer.config import MaintenanceSettings
from razer.volume.support_pruning import SupportPruning, support_ratios
from razer.volume.voxel_map import VoxelMap
from tests.support.scenes import COARSE, axis_box, cells_at, frame_of, look

SETTINGS = MaintenanceSettings(max_misses=3, min_support=0.1, keep_confidence=0.7)
SURFACE = look(frame_of(np.full((120, 160), 2.0)))
AHEAD, BEHIND, ASIDE, BEYOND = ((0, 0, 1.5), (0, 0, -1.5), (3, 0, 1.5), (0, 0, 2.5))


def after(
    n_frames: int, place: tuple[float, ...] = AHEAD, *, matched: bool = False, support: float = 1.0, sure: float = 0.0
) -> list[int]:
    """What is pruned after so many frames of one track, with support measured after each."""
    pruning, gone = SupportPruning(SETTINGS), []
    for _ in range(n_frames):
        pruning.count_frame(SURFACE, {1: axis_box(place, (0.1, 0.1, 0.1))}, {1} if matched else set())
        gone = pruning.doomed({1: support}, {1: sure})
    return gone


@pytest.mark.parametrize(
    ("gone", "expected"),
    [
        (after(2), []),
        (after(3), [1]),
        (after(3, BEHIND), []),
        (after(3, ASIDE), []),
        (after(3, BEYOND), []),
        (after(3, matched=True), []),
        (after(2, matched=True, support=0.05), []),
        (after(3, matched=True, support=0.05), [1]),
        (after(3, matched=True, support=0.1), []),
        (after(3, sure=0.7), [1]),  # as sure as tau_conf is not surer
        (after(3, sure=0.71), []),
        (after(3, support=0.05, sure=0.71), []),
    ],
)
def test_k_frames_in_a_row_without_a_match_or_support(gone: list[int], expected: list[int]) -> None:
    assert gone == expected


def test_a_match_or_support_begins_the_count_anew() -> None:
    pruning, box = SupportPruning(SETTINGS), {1: axis_box(AHEAD, (0.1, 0.1, 0.1))}
    for matched, support in ((False, 0.0), (False, 0.0), (True, 1.0), (False, 0.0), (False, 0.0)):
        pruning.count_frame(SURFACE, box, {1} if matched else set())
        assert pruning.doomed({1: support}, {1: 0.0}) == []
    pruning.count_frame(SURFACE, box, {1})
    assert pruning.doomed({1: 0.0}, {1: 0.0}) == [1], "matched, but three frames without support"


def test_support_measured_now_and_then_counts_for_the_frames_between() -> None:
    pruning, box = SupportPruning(SETTINGS), {1: axis_box(AHEAD, (0.1, 0.1, 0.1))}
    for _ in range(3):
        pruning.count_frame(SURFACE, box, {1})
    assert pruning.doomed({1: 0.0}, {1: 0.0}) == [1]
    assert pruning.doomed({}, {}) == [], "what is gone is forgotten"


def test_support_is_the_filled_share_of_the_box() -> None:
    voxels = VoxelMap(COARSE)
    voxels.admit(4)
    voxels.allocate(np.zeros((1, 3), np.int32))
    voxels.vote(cells_at([[x, y, 0] for x in range(4) for y in range(5)]), np.repeat([1, 2], [15, 5]).astype(np.int32))
    voxels.replace(2, 1)
    boxes = {1: axis_box((0, 0, 0), (0.4, 0.4, 0.4)), 4: axis_box((0, 0, 0), (1, 1, 1))}
    assert support_ratios(voxels, boxes) == pytest.approx({1: 20 / 1000, 4: 0.0})
    flat = {1: axis_box((0, 0, 0), (0.16, 0.2, 0.0))}
    assert support_ratios(voxels, flat) == pytest.approx({1: 1.0})
    assert support_ratios(voxels, {}) == {}
