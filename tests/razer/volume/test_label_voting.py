"""Votes of whole frames: who gains, who loses, and who keeps what it has; against a slow count for each cell."""

from __future__ import annotations

from collections import Counter
from dataclasses import replace
from itertools import permutations

import numpy as np
import pytest

from razer.detection.observed_surface import ObservedSurface
from razer.frame import Frame, Intrinsics
from razer.volume.label_voting import BORDER_PIXELS, id_image, vote
from razer.volume.voxel_map import VoxelMap
from tests.support.scenes import COARSE, axis_box, detection, frame_of, look

WALL = frame_of(np.full((120, 160), 2.0))
# Posts before the wall, from where they share its cells to where they do not; and an image whose border is odd.
POST_M = np.repeat(np.arange(32) * 7 % 16 / 100, 5) * (np.arange(160) // 5 % 2)
POSTS = frame_of(2.0 - POST_M * np.ones((120, 1)))
LARGE = frame_of(np.full((165, 220), 2.0), camera=Intrinsics(220, 165, 190.0, 190.0, 109.5, 82.0))
BORDER = BORDER_PIXELS * 120 // 480
THING, TABLE, BOOK = 1, 2, 3
EVERYTHING, LEFT, MIDDLE = (slice(None), slice(0, 160)), (slice(None), slice(0, 60)), (slice(40, 80), slice(60, 100))


def mapped(frame: Frame = WALL) -> tuple[VoxelMap, ObservedSurface]:
    voxels = VoxelMap(COARSE.model_copy(update={"histogram_slots": 8}))
    surface = look(frame)
    voxels.integrate(frame, surface)
    voxels.admit(9)
    return voxels, surface


def show(voxels: VoxelMap, surface: ObservedSurface, withdraw: bool = True, **masks: object) -> np.ndarray:
    """One frame with masks {id as "i1": part of the image}."""
    found = []
    for part in masks.values():
        inside = np.zeros(surface.depth.shape, bool)
        inside[part] = True
        pixels = np.flatnonzero(inside[surface.rows, surface.columns]).astype(np.int32)
        found.append(replace(detection(axis_box((0, 0, 2), (1, 1, 1))), pixels=pixels))
    return vote(voxels, surface, found, np.array([int(name[1:]) for name in masks], np.int32), withdraw)


def labels_at(voxels: VoxelMap, surface: ObservedSurface, row: int, column: int) -> int:
    reading = np.flatnonzero((surface.rows == row) & (surface.columns == column))[0]
    return int(voxels.labels_at(surface.cells)[surface.pixel_cell[reading]])


def test_what_a_mask_spilled_over_once_is_taken_back() -> None:
    voxels, surface = mapped()
    show(voxels, surface, i1=EVERYTHING)
    assert labels_at(voxels, surface, 60, 100) == THING
    show(voxels, surface, i1=LEFT)
    assert labels_at(voxels, surface, 60, 100) == 0
    assert labels_at(voxels, surface, 60, 20) == THING


def test_what_is_not_in_the_frame_keeps_its_votes() -> None:
    voxels, surface = mapped()
    show(voxels, surface, i1=LEFT)
    for _ in range(3):
        show(voxels, surface)
        show(voxels, surface, i3=MIDDLE)
    assert labels_at(voxels, surface, 60, 20) == THING


def test_the_border_of_a_mask_is_unsure_and_keeps_its_votes() -> None:
    voxels, surface = mapped()
    show(voxels, surface, i1=EVERYTHING)
    show(voxels, surface, i1=LEFT)
    assert labels_at(voxels, surface, 60, 59 + BORDER - 1) == THING
    assert labels_at(voxels, surface, 60, 59 + BORDER + 5) == 0  # a voxel is three pixels wide


def test_a_book_found_in_few_frames_is_not_the_table_it_lies_on() -> None:
    def label(withdraw: bool) -> int:
        voxels, surface = mapped()
        for _ in range(6):
            show(voxels, surface, withdraw, i2=EVERYTHING)
        for _ in range(4):
            show(voxels, surface, withdraw, i2=EVERYTHING, i3=MIDDLE)
        assert labels_at(voxels, surface, 60, 20) == TABLE
        return labels_at(voxels, surface, 60, 80)

    assert label(withdraw=True) == BOOK
    assert label(withdraw=False) == TABLE


@pytest.mark.parametrize("order", list(permutations(range(3))))
def test_of_masks_one_on_the_other_the_smallest_is_seen(order: tuple[int, ...]) -> None:
    voxels, surface = mapped()
    masks = [("i1", EVERYTHING), ("i2", MIDDLE), ("i3", (slice(50, 60), slice(70, 80)))]
    ids = show(voxels, surface, **dict(masks[i] for i in order))
    assert [ids[10, 10], ids[45, 65], ids[55, 75]] == [1, 2, 3]


def test_votes_may_be_withdrawn_unless_told_otherwise() -> None:
    voxels, surface = mapped()
    first, other = (replace(detection(axis_box((0, 0, 2), (1, 1, 1))), pixels=part) for part in halves(surface))
    vote(voxels, surface, [first, other], np.array([1, 1], np.int32))
    vote(voxels, surface, [other], np.array([1], np.int32))
    assert labels_at(voxels, surface, 60, 20) == 0
    assert labels_at(voxels, surface, 60, 140) == 1


@pytest.mark.parametrize("stuff_is_listed_first", [True, False])
def test_things_are_seen_before_stuff_however_small(stuff_is_listed_first: bool) -> None:
    """A patch of floor that is left beside a couch in the image."""
    _, surface = mapped()
    couch, _ = halves(surface)
    thing = replace(detection(axis_box((0, 0, 2), (1, 1, 1))), pixels=couch)
    stuff = replace(thing, pixels=couch[::2], is_stuff=True)
    found = [(stuff, 2), (thing, 1)] if stuff_is_listed_first else [(thing, 1), (stuff, 2)]
    ids = id_image(surface, [d for d, _ in found], np.array([i for _, i in found], np.int32))
    assert set(np.unique(ids)) == {0, 1}


@pytest.mark.parametrize("spared", [None, {0: [2]}, {0: [3]}])
def test_voxels_of_spared_tracks_do_not_vote_for_a_mask_over_them(spared: dict[int, list[int]] | None) -> None:
    voxels, surface = mapped()
    left, right = (replace(detection(axis_box((0, 0, 2), (1, 1, 1))), pixels=part) for part in halves(surface))
    both = replace(left, pixels=np.concatenate([left.pixels, right.pixels]))
    vote(voxels, surface, [left, right], np.array([1, 2], np.int32))
    for _ in range(3):
        ids = vote(voxels, surface, [both], np.array([1], np.int32), spared=spared)
    is_spared = spared == {0: [2]}
    assert labels_at(voxels, surface, 60, 140) == ids[60, 140] + 2 * is_spared == (2 if is_spared else 1)
    assert labels_at(voxels, surface, 60, 20) == ids[60, 20] == 1


def halves(surface: ObservedSurface) -> tuple[np.ndarray, np.ndarray]:
    """The pixels left and right of the middle, as detections list them."""
    left = surface.columns < 80
    return np.flatnonzero(left).astype(np.int32), np.flatnonzero(~left).astype(np.int32)


@pytest.mark.parametrize("frame", [WALL, POSTS, LARGE], ids=["wall", "posts", "large"])
def test_votes_agree_with_a_slow_count_also_after_a_fusion(frame: Frame) -> None:
    rng = np.random.default_rng(0)
    voxels, surface = mapped(frame)
    row, column, z, on_image = surface.pixels_of(surface.cells.points)
    border = round(BORDER_PIXELS * len(surface.depth) / 480)
    some = np.arange(0, len(surface.cells), 3)
    counts: dict[int, Counter[int]] = {cell: Counter() for cell in some.tolist()}
    alive = {i: i for i in range(10)}
    for number in range(12):
        if number == 6:
            voxels.replace(4, 2)
            alive[4] = 2
            counts = {
                cell: Counter({i: n for i, n in c.items() if i != 4} | {2: c[2] + c[4]}) for cell, c in counts.items()
            }
        corners = rng.integers(0, [90, 120], (4, 2))
        parts = [(slice(y, y + rng.integers(20, 60)), slice(x, x + rng.integers(20, 80))) for y, x in corners.tolist()]
        chosen = rng.choice(np.arange(1, 6), 4, replace=False).tolist()
        ids = show(voxels, surface, **{f"i{i}": part for i, part in zip(chosen, parts, strict=True)})
        shown = set(ids[ids > 0].tolist())
        assert shown <= set(alive.values())
        for cell, count in counts.items():
            if not on_image[cell] or abs(surface.depth[row[cell], column[cell]] - z[cell]) > 0.08:
                continue
            y, x = row[cell], column[cell]
            around = ids[max(y - border, 0) : y + border + 1, max(x - border, 0) : x + border + 1]
            if np.unique(around).size == 1:
                for instance in shown - {int(ids[y, x])}:
                    count[instance] = max(0, count[instance] - 1)
            if ids[y, x]:
                count[int(ids[y, x])] += 1
    winners = [min(((-n, i) for i, n in count.items() if n > 0), default=(0, 0))[1] for count in counts.values()]
    assert len(set(winners)) > 4
    np.testing.assert_array_equal(np.array(voxels.labels_at(surface.cells).tolist())[some], winners)
