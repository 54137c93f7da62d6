"""From masks to detections: filters and erosion by slow references, lifting on hand-made depth."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays
from numpy.testing import assert_allclose
from scipy.ndimage import binary_erosion

from razer.boxes.oriented_box import OrientedBox, PointMoments
from razer.config import LiftingSettings, MaskSettings
from razer.detection.background_filter import background_clusters
from razer.detection.lifting import Lifted, filter_masks, lift, shrink, view_quality
from razer.detection.observed_surface import ObservedSurface
from razer.frame import Frame, Intrinsics, Masks
from tests.support.scenes import CAMERA, COARSE, frame_of, look, unit

LIFTING = LiftingSettings(dbscan_eps_m=0.08, dbscan_min_points=4, min_cells=8)
SHAPE = (CAMERA.height, CAMERA.width)


def rectangle(top: int, bottom: int, left: int, right: int) -> np.ndarray:
    mask = np.zeros(SHAPE, bool)
    mask[top:bottom, left:right] = True
    return mask


def masks_of(*masks: np.ndarray, scores: list[float] | None = None, names: tuple[str, ...] | None = None) -> Masks:
    return Masks(np.stack(masks), np.array(scores or [1.0] * len(masks), np.float32), names)


@given(
    mask=arrays(np.bool_, st.tuples(st.integers(3, 16), st.integers(3, 16)), elements=st.integers(0, 3).map(bool)),
    pixels=st.integers(0, 3),
)
@settings(deadline=None, max_examples=80)
def test_shrink_is_erosion_by_a_square_with_the_image_border_inside(mask: np.ndarray, pixels: int) -> None:
    size = 2 * pixels + 1
    expected = binary_erosion(mask, np.ones((size, size)), border_value=1) if pixels else mask
    assert np.array_equal(shrink(mask[None], pixels)[0], expected)


def test_shrink_treats_each_mask_alone_and_leaves_the_input() -> None:
    masks = np.stack([rectangle(0, 20, 0, 20), rectangle(50, 51, 50, 90), np.zeros(SHAPE, bool)])
    before = masks.copy()
    shrunk = shrink(masks, 2)
    assert np.array_equal(shrunk[0], rectangle(0, 18, 0, 18))
    assert not shrunk[1:].any()
    assert np.array_equal(masks, before)


def test_filter_drops_small_unsure_and_depthless_masks() -> None:
    depth = np.full(SHAPE, 2.0)
    depth[:, :40] = 0
    masks = masks_of(
        rectangle(0, 20, 60, 80),  # kept
        rectangle(0, 2, 60, 70),  # 20 pixels; 400 at 640x480 are 25 here
        rectangle(20, 40, 60, 80),  # not sure enough
        rectangle(40, 60, 20, 41),  # 1 column in 21 has depth
        rectangle(60, 80, 20, 60),  # half of it has depth: kept
        scores=[0.9, 0.9, 0.2, 0.9, 0.25],
    )
    kept = filter_masks(frame_of(depth), masks, MaskSettings())
    assert np.array_equal(kept.masks, masks.masks[[0, 4]])
    assert_allclose(kept.scores, [0.9, 0.25])


def test_filter_of_no_masks_is_no_masks() -> None:
    assert len(filter_masks(frame_of(np.ones(SHAPE)), Masks.none(*SHAPE), MaskSettings())) == 0


def two_plates() -> Frame:
    """A wall at 2 m with a plate half a metre before it."""
    depth = np.full(SHAPE, 2.0)
    depth[40:80, 60:100] = 1.5
    return frame_of(depth)


def lifted(frame: Frame, masks: Masks, embeddings: np.ndarray | None = None, shrink_pixels: int = 0) -> Lifted:
    vectors = np.tile(unit(1, 0), (len(masks), 1)) if embeddings is None else embeddings
    return lift(look(frame), masks, vectors, LIFTING, shrink_pixels)


def test_a_mask_across_a_depth_gap_becomes_two_detections() -> None:
    found = lifted(two_plates(), masks_of(rectangle(30, 90, 50, 110))).detections
    assert [d.mask for d in found] == [0, 0]
    assert found[0].n_cells > found[1].n_cells
    depths = [d.box.center[2] for d in found]
    assert depths == pytest.approx([2.0, 1.5], abs=COARSE.voxel_size_m)


def test_what_is_seen_past_the_object_is_no_part_of_it() -> None:
    frame, mask = two_plates(), rectangle(40, 80, 60, 120)  # the plate, and half as much of the wall
    (found,) = lifted(frame, masks_of(mask)).detections
    assert found.box.center[2] == pytest.approx(1.5, abs=COARSE.voxel_size_m)
    result = lifted(frame, masks_of(mask))
    assert np.array_equal(np.sort(result.member_cell), np.sort(found.cells))
    # A wall that stands no farther behind than things are deep may be a part of it.
    near = LIFTING.model_copy(update={"background_gap_m": 0.6})
    assert len(lift(look(frame), masks_of(mask), unit(1, 0)[None], near, 0).detections) == 2


@pytest.mark.parametrize(
    ("gaps_m", "sizes_m", "counts", "expected"),
    [
        ((0.0, 0.5), (0.4, 1.0), (100, 50), [1]),  # farther behind than half the first one's size
        ((0.0, 0.5), (1.2, 1.0), (100, 50), []),  # the hidden middle of a long table
        ((0.0, 0.2), (0.1, 0.1), (100, 50), []),  # nearer than any gap that counts
        ((0.0, 0.5), (0.4, 0.4), (50, 100), []),  # the larger piece is the object: what is before it stays
        ((0.0, 0.5, 0.9, 0.1), (0.4, 1.0, 1.0, 0.2), (100, 50, 50, 50), [1, 2]),
    ],
)
def test_pieces_far_behind_the_largest(gaps_m, sizes_m, counts, expected) -> None:
    depths = [np.full(n, 2 + gap, np.float32) for gap, n in zip(gaps_m, counts, strict=True)]
    boxes = [OrientedBox(np.zeros(3), np.eye(3), np.array([size, 0.1, 0.1])) for size in sizes_m]
    assert background_clusters(depths, boxes, 0.3) == expected


def test_box_of_a_plate_is_the_plate() -> None:
    plate = lifted(two_plates(), masks_of(rectangle(40, 80, 60, 100))).detections
    assert len(plate) == 1
    # 40 pixels at 1.5 m are 0.43 m wide; cells quantise it by a voxel.
    assert_allclose(np.sort(plate[0].box.extent)[1:], 1.5 * 40 / 140, atol=COARSE.voxel_size_m)
    assert plate[0].box.extent.min() == pytest.approx(0.0, abs=1e-9)
    assert_allclose(plate[0].box.center, [0, 0, 1.5], atol=COARSE.voxel_size_m)


def test_cells_and_pixels_of_a_detection_belong_together() -> None:
    frame, mask = two_plates(), rectangle(30, 90, 50, 110)
    surface = look(frame)
    for found in lifted(frame, masks_of(mask)).detections:
        assert mask[surface.rows[found.pixels], surface.columns[found.pixels]].all()
        assert np.array_equal(np.unique(surface.pixel_cell[found.pixels]), np.sort(found.cells))
        expected = PointMoments.of(surface.cells.points[found.cells])
        assert found.moments.count == expected.count == found.n_cells
        assert_allclose(found.moments.scatter, expected.scatter)
        assert found.box.contains(surface.cells.points[found.cells], 1e-9).all()


def test_detections_are_ordered_and_carry_what_their_mask_says() -> None:
    masks = masks_of(rectangle(45, 75, 65, 95), rectangle(30, 90, 50, 110), scores=[0.4, 0.8], names=("plate", "all"))
    vectors = np.stack([unit(1, 0), unit(0, 1)])
    found = lifted(two_plates(), masks, vectors).detections
    assert [d.mask for d in found] == [0, 1, 1]
    assert [d.class_name for d in found] == ["plate", "all", "all"]
    assert [d.score for d in found] == pytest.approx([0.4, 0.8, 0.8])
    assert all(np.array_equal(d.embedding, vectors[d.mask]) for d in found)
    # The two parts of the second mask share it: 2000 pixels of wall, 1600 of plate.
    assert [d.quality for d in found] == pytest.approx(
        [0.4 * 900 / 4900, 0.8 * (2000 / 3600) * 2000 / 6000, 0.8 * (1600 / 3600) * 1600 / 5600]
    )


def test_members_are_the_distinct_cells_of_each_mask() -> None:
    masks = masks_of(rectangle(30, 90, 50, 110), rectangle(0, 60, 0, 80))
    surface, result = look(two_plates()), lifted(two_plates(), masks)
    expected = set()
    for cell, row, column in zip(surface.pixel_cell, surface.rows, surface.columns, strict=True):
        expected |= {(int(cell), n) for n in range(2) if masks.masks[n, row, column]}
    found = list(zip(result.member_cell.tolist(), result.member_mask.tolist(), strict=True))
    assert found == sorted(expected)


def test_clusters_below_the_least_size_are_no_detections_but_members() -> None:
    result = lifted(two_plates(), masks_of(rectangle(40, 48, 60, 68)))  # 8x8 pixels: 2 x 2 or 3 x 3 cells
    strict = lift(
        look(two_plates()), masks_of(rectangle(40, 48, 60, 68)), unit(1, 0)[None],
        LIFTING.model_copy(update={"min_cells": 20}), 0,
    )  # fmt: skip
    assert strict.detections == ()
    assert np.array_equal(strict.member_cell, result.member_cell)
    assert len(strict.member_cell) > 0


def test_masks_are_shrunk_in_proportion_to_the_image() -> None:
    # 8 pixels at 480 rows are 2 at 120.
    frame, mask = two_plates(), rectangle(30, 90, 50, 110)
    assert np.array_equal(
        lifted(frame, masks_of(mask), shrink_pixels=8).member_cell,
        lifted(frame, masks_of(rectangle(32, 88, 52, 108))).member_cell,
    )


def test_a_strided_surface_lifts_the_same_plate() -> None:
    fine = Intrinsics(640, 480, 560.0, 560.0, 319.5, 239.5)
    depth = np.full((480, 640), 2.0)
    depth[160:320, 240:400] = 1.5
    frame = frame_of(depth, camera=fine)
    surface = ObservedSurface.of(frame, 0.04, 0.1, 5.0)
    mask = np.zeros((1, 480, 640), bool)
    mask[0, 160:320, 240:400] = True
    plate = lift(surface, Masks(mask, np.ones(1, np.float32)), unit(1, 0)[None], LIFTING, 0).detections
    assert surface.stride == 4
    assert len(plate) == 1
    assert_allclose(np.sort(plate[0].box.extent)[1:], 1.5 * 160 / 560, atol=0.04)
    assert plate[0].quality == pytest.approx(160**2 / (160**2 + 4000))


def test_no_masks_lift_to_nothing() -> None:
    result = lifted(two_plates(), Masks.none(*SHAPE), np.zeros((0, 2), np.float32))
    assert result.detections == ()
    assert len(result.member_cell) == len(result.member_mask) == 0


def test_a_mask_without_depth_lifts_to_nothing() -> None:
    depth = np.full(SHAPE, 2.0)
    depth[:60] = 0
    assert lifted(frame_of(depth), masks_of(rectangle(10, 50, 10, 90))).detections == ()


@given(score=st.floats(0, 1), share=st.floats(0, 1), pixels=st.integers(0, 10**7))
def test_view_quality_is_a_share_that_grows_with_each_part(score: float, share: float, pixels: int) -> None:
    quality = view_quality(score, share, pixels)
    assert 0 <= quality <= score * share <= 1
    assert view_quality(score, share, pixels + 1000) >= quality
    assert view_quality(1.0, share, pixels) >= quality
