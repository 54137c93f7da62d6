"""Consistency of masks from view to view: hand-made views, and a pixel-by-pixel reference."""

from __future__ import annotations

import numpy as np
import pytest

from app.mask_quality.mask_consistency import MaskConsistency, View, carried_pixels, carry
from data_tools.synthetic.synthetic_room import SyntheticRoom
from razer.frame import Frame, Masks
from tests.support.profile_frames import true_frame

HEIGHT, WIDTH = 60, 80


def view(index: int, boxes: dict[tuple[int, int, int, int], str], shift_px: int = 0) -> View:
    """Named boxes (top, left, bottom, right) on a wall 2 m away, seen from a camera that stands so many pixels to the
    right."""
    pose = np.eye(4)
    pose[0, 3] = shift_px * 2.0 / WIDTH
    frame = true_frame(np.zeros((HEIGHT, WIDTH), int), {}, index, world_from_camera=pose)
    masks = np.zeros((len(boxes), HEIGHT, WIDTH), np.bool_)
    for mask, (top, left, bottom, right) in zip(masks, boxes, strict=True):
        mask[top:bottom, max(left - shift_px, 0) : max(right - shift_px, 0)] = True
    return View(frame, Masks(masks, np.ones(len(boxes), np.float32), tuple(boxes.values())))


CUP, BED, BOX = (10, 20, 20, 30), (30, 10, 58, 40), (10, 50, 30, 70)


def test_what_stays_is_matched_and_what_goes_is_missed():
    views = [view(0, {CUP: "cup", BED: "bed", BOX: "box"}), view(1, {CUP: "vase", BED: "bed"})]
    result = MaskConsistency.of(views).to_json()
    assert result["views"] == 2
    assert result["masks_a_view"] == 2.5
    assert result["seen_again"] == 1
    # Three from the first to the second, two back.
    assert result["compared"] == 5
    assert result["missed"] == pytest.approx(1 / 5)
    assert result["renamed"] == pytest.approx(2 / 4)
    assert result["iou"] == 1
    assert result["missed_again"] is None
    by_size = {one["from_px"]: (one["compared"], one["missed"]) for one in result["missed_by_size"]}
    assert by_size == {0: (2, 0), 300: (3, 1 / 3), 1000: (0, None), 3000: (0, None), 10000: (0, None)}


def test_iou_is_that_of_the_masks_where_both_views_look():
    wider = (10, 50, 30, 74)
    carried, asked = carry(view(0, {BOX: "box"}), view(1, {wider: "box", CUP: "cup"}))
    assert asked.tolist() == [True]
    assert carried.iou == pytest.approx(20 / 24)
    assert carried.sizes_px.tolist() == [400]


def test_a_moved_camera_carries_masks_along_and_asks_only_for_what_it_sees():
    names = {CUP: "cup", BOX: "box"}
    here, there = view(0, names), view(1, names, shift_px=24)
    carried, asked = carry(here, there)
    # The cup at columns 20 to 30 is out of view by more than half, the box is not.
    assert asked.tolist() == [False, True]
    assert carried.iou == pytest.approx(1)
    assert carry(there, here)[1].tolist() == [True, True]


def test_something_before_the_mask_is_no_miss():
    here, there = view(0, {BOX: "box"}), view(1, {})
    depth = there.frame.depth.copy()
    depth[5:35, 45:75] = 1.0
    hidden = Frame(1, 0.0, there.frame.rgb, depth, there.frame.intrinsics, there.frame.pose)
    assert carry(here, View(hidden, there.masks))[1].tolist() == [False]
    assert carry(here, there)[0].missed.tolist() == [True]


def test_missed_again_counts_those_missed_in_the_next_view_and_the_one_after():
    none: dict[tuple[int, int, int, int], str] = {}
    twice = MaskConsistency.of([view(0, {CUP: "cup", BED: "bed"}), view(1, none), view(2, {BED: "bed"})])
    assert twice.to_json()["missed_again"] == pytest.approx(1 / 2)
    never = MaskConsistency.of([view(i, {CUP: "cup"}) for i in range(3)]).to_json()
    assert never["missed_again"] is None
    assert never["missed"] == 0


def test_masks_without_names_are_never_renamed_and_no_masks_are_nothing():
    frame = view(0, {}).frame
    nameless = Masks(view(0, {CUP: "cup"}).masks.masks, np.ones(1, np.float32))
    assert MaskConsistency.of([View(frame, nameless), View(frame, nameless)]).to_json()["renamed"] == 0
    empty = MaskConsistency.of([View(frame, Masks.none(HEIGHT, WIDTH))] * 3).to_json()
    assert (empty["compared"], empty["missed"], empty["iou"]) == (0, None, None)
    assert MaskConsistency.of([]).to_json()["masks_a_view"] == 0


def test_pixels_are_carried_as_one_by_one():
    room = SyntheticRoom(0, n_frames=12, width=48, height=36)
    a, b = room[2], room[4]
    expected = []
    for row in range(0, 36, 2):
        for column in range(0, 48, 2):
            z = float(b.depth[row, column])
            ray = np.array([(column - b.intrinsics.cx) / b.intrinsics.fx, (row - b.intrinsics.cy) / b.intrinsics.fy, 1])
            x, y, far = (np.linalg.inv(a.pose) @ b.pose @ np.array([*(ray * z), 1]))[:3]
            if z == 0 or far <= 0:
                continue
            u, v = (
                round(x / far * a.intrinsics.fx + a.intrinsics.cx),
                round(y / far * a.intrinsics.fy + a.intrinsics.cy),
            )
            if 0 <= u < 48 and 0 <= v < 36 and abs(a.depth[v, u] - far) < 0.03 * far:
                expected.append((v * 48 + u, row * 48 + column))
    assert len(expected) > 100
    assert list(zip(*(side.tolist() for side in carried_pixels(a, b)), strict=True)) == expected
