"""Votes of whole frames: who gains, who loses, and who keeps what it has; against a slow count for each cell."""

from __future__ import annotations

from collections import Counter
from dataclasses import replace

import numpy as np

from razer.detection.observed_surface import ObservedSurface
from razer.volume.label_voting import BORDER_PIXELS, vote
from razer.volume.voxel_map import VoxelMap
from tests.support.scenes import COARSE, axis_box, detection, frame_of, look

WALL = frame_of(np.full((120, 160), 2.0))
BORDER = BORDER_PIXELS * 120 // 480
THING, TABLE, BOOK = 1, 2, 3
EVERYTHING, LEFT, MIDDLE = (slice(None), slice(0, 160)), (slice(None), slice(0, 60)), (slice(40, 80), slice(60, 100))


def mapped() -> tuple[VoxelMap, ObservedSurface]:
    voxels = VoxelMap(COARSE.model_copy(update={"histogram_slots": 8}))
    surface = look(WALL)
    voxels.integrate(WALL, surface)
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


def test_votes_agree_with_a_slow_count_also_after_a_fusion() -> None:
    rng = np.random.default_rng(0)
    voxels, surface = mapped()
    row, column, z, on_image = surface.pixels_of(surface.cells.points)
    some = np.arange(0, len(surface.cells), 7)
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
            around = ids[max(y - BORDER, 0) : y + BORDER + 1, max(x - BORDER, 0) : x + BORDER + 1]
            if np.unique(around).size == 1:
                for instance in shown - {int(ids[y, x])}:
                    count[instance] = max(0, count[instance] - 1)
            if ids[y, x]:
                count[int(ids[y, x])] += 1
    winners = [min(((-n, i) for i, n in count.items() if n > 0), default=(0, 0))[1] for count in counts.values()]
    assert len(set(winners)) > 4
    np.testing.assert_array_equal(np.array(voxels.labels_at(surface.cells).tolist())[some], winners)
