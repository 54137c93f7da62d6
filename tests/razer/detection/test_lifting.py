"""From masks to detections: filters and erosion by slow references, lifting on hand-made depth."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays
from numpy.testing import assert_allclose
from scipy.ndimage import binary_erosion

from razer.boxes.oriented_box import PointMoments
from razer.config import LiftingSettings, MaskSettings
from razer.detection.background_filter import background_limit_m
from razer.detection.lifting import Detection, Lifted, cut_share, filter_masks, lift, shrink, view_quality
from razer.detection.observed_surface import ObservedSurface
from razer.frame import Frame, Intrinsics, Masks
from tests.support.scenes import CAMERA, COARSE, frame_of, look, plane_depth, unit

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
        rectangle(0, 2, 60, 62),  # 4 pixels; 128 at 640x480 are 8 here
        rectangle(20, 40, 60, 80),  # not sure enough
        rectangle(40, 60, 20, 41),  # 1 column in 21 has depth
        rectangle(60, 80, 20, 60),  # half of it has depth: kept
        scores=[0.9, 0.9, 0.2, 0.9, 0.25],
    )
    kept = filter_masks(frame_of(depth), masks, MaskSettings(min_pixels=128))
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


def readings_of(frame: Frame, mask: np.ndarray) -> set[tuple[int, int]]:
    """All pixels of a mask with depth, for comparison."""
    return set(zip(*np.nonzero(mask & (frame.depth > 0)), strict=True))


def pixels_of(frame: Frame, found: Detection) -> set[tuple[int, int]]:
    surface = look(frame)
    return set(zip(surface.rows[found.pixels].tolist(), surface.columns[found.pixels].tolist(), strict=True))


def test_of_a_mask_across_a_depth_gap_the_nearer_part_is_the_thing() -> None:
    """Of a thing that is seen through there may be less than of what is behind it: 1,600 pixels and 2,000 here."""
    frame, mask = two_plates(), rectangle(30, 90, 50, 110)
    (found,) = lifted(frame, masks_of(mask)).detections
    assert pixels_of(frame, found) == readings_of(frame, mask & (frame.depth < 1.6))
    assert found.quality == pytest.approx(1600 / 3600 * 1600 / 5600)


def test_a_splinter_before_the_thing_belongs_to_its_mask() -> None:
    """A tenth of the mask is nearer by more than the gap: an edge of the mask on what hides the thing."""
    frame, mask = two_plates(), rectangle(0, 60, 0, 80)
    (found,) = lifted(frame, masks_of(mask)).detections
    assert pixels_of(frame, found) == readings_of(frame, mask)


def stool() -> tuple[Frame, np.ndarray]:
    """A seat at 1.5 m, two legs a pixel wide that a near board hides at the top, a wall far behind; and its mask."""
    depth, mask = np.full(SHAPE, 4.0), np.zeros(SHAPE, bool)
    for part in (np.s_[20:40, 40:100], np.s_[40:100, 45], np.s_[40:100, 90]):
        depth[part], mask[part] = 1.5, True
    depth[40:56], mask[40:56] = 0.8, False
    return frame_of(depth), mask


@pytest.mark.parametrize("min_points", [4, 10])  # the legs are clusters of their own, or noise
def test_seat_and_legs_of_a_stool_are_one_detection(min_points: int) -> None:
    frame, mask = stool()
    settings = LIFTING.model_copy(update={"dbscan_min_points": min_points})
    (found,) = lift(look(frame), masks_of(mask), unit(1, 0)[None], settings, 0).detections
    assert pixels_of(frame, found) == readings_of(frame, mask)
    # From the seat's upper edge to the feet: 80 rows at 1.5 m.
    assert found.box.extent.max() == pytest.approx(1.5 * 80 / 140, abs=2 * COARSE.voxel_size_m)


def test_a_thing_behind_a_bar_is_one_detection() -> None:
    depth, mask = np.full(SHAPE, 4.0), rectangle(30, 90, 20, 140)
    depth[mask] = 2.0
    depth[:, 70:85], mask[:, 70:85] = 1.0, False
    frame = frame_of(depth)
    (found,) = lifted(frame, masks_of(mask)).detections
    assert pixels_of(frame, found) == readings_of(frame, mask)
    assert found.box.extent.max() == pytest.approx(2.0 * 120 / 140, abs=2 * COARSE.voxel_size_m)


def test_sparse_readings_of_a_far_floor_belong_to_it() -> None:
    """Beyond 3.7 m its rows are more than epsilon apart: noise to DBSCAN, and floor all the same."""
    depth = plane_depth(np.eye(4), (0, 1, 0), 1.2)
    frame = frame_of(np.where(depth <= 5, depth, 0))
    settings = LIFTING.model_copy(update={"dbscan_min_points": 10})
    mask = rectangle(97, 120, 0, 160)  # from 2.8 to 4.5 m
    (found,) = lift(look(frame), masks_of(mask), unit(1, 0)[None], settings, 0).detections
    assert pixels_of(frame, found) == readings_of(frame, mask)
    assert found.box.contains(np.array([[0, 1.2, 4.4], [0, 1.2, 2.9]]), COARSE.voxel_size_m).all()


def test_what_is_seen_past_the_object_is_no_part_of_it() -> None:
    frame, mask = two_plates(), rectangle(40, 80, 60, 120)  # the plate, and half as much of the wall
    (found,) = lifted(frame, masks_of(mask)).detections
    assert found.box.center[2] == pytest.approx(1.5, abs=COARSE.voxel_size_m)
    result = lifted(frame, masks_of(mask))
    assert np.array_equal(np.sort(result.member_cell), np.sort(found.cells))
    assert found.quality == pytest.approx((1600 / 2400) * 1600 / 5600)
    # A wall that stands no farther behind than things are deep may be a part of it.
    near = LIFTING.model_copy(update={"background_gap_m": 0.6})
    (both,) = lift(look(frame), masks_of(mask), unit(1, 0)[None], near, 0).detections
    assert len(both.pixels) == 2400


def test_stray_readings_of_the_wall_behind_stay_out_though_they_are_no_cluster() -> None:
    """A mask that spills over its thing by a pixel all around: too little for a cluster, and not the thing's."""
    frame = two_plates()
    (found,) = lifted(frame, masks_of(rectangle(39, 81, 59, 101))).detections
    assert pixels_of(frame, found) == readings_of(frame, rectangle(40, 80, 60, 100))


@pytest.mark.parametrize(
    ("depths_m", "size_m", "min_gap_m", "limit_m"),
    [
        ([2.0], 0.4, 0.3, 2.3),  # small: the least gap
        ([2.0], 1.2, 0.3, 2.6),  # half the size of the thing: the hidden middle of a long table
        ([2.0], 1.2, 0.8, 2.8),
        (np.linspace(2.0, 3.0, 101), 0.4, 0.3, 3.2),  # behind the depth that nine tenths of it are nearer than
        ([2.0] * 95 + [9.0] * 5, 0.4, 0.3, 2.3),  # a few readings beyond its edge do not count
    ],
)
def test_background_begins_a_gap_behind_the_only_cluster(
    depths_m: list[float], size_m: float, min_gap_m: float, limit_m: float
) -> None:
    points = np.array([[0, 0, 2], [size_m, 0, 2], [size_m / 2, 0.05, 2], [size_m / 2, -0.05, 2]], float)
    limit = background_limit_m([np.asarray(depths_m, np.float32)], [points], min_gap_m)
    assert limit == pytest.approx(limit_m, abs=1e-5)


@pytest.mark.parametrize(
    ("clusters", "limit_m"),
    [
        ([(2.0, 100), (2.8, 400)], 2.3),  # a chair before a wall of which more is seen
        ([(2.0, 99), (2.8, 400)], 3.1),  # less than a quarter: a splinter, and the mask is of what is behind
        ([(2.0, 100), (2.25, 40), (2.5, 100), (2.9, 100)], 2.8),  # it goes on in steps of less than the gap
        ([(2.9, 100), (2.5, 100), (2.25, 40), (2.0, 100)], 2.8),  # in whatever order
    ],
)
def test_background_begins_behind_the_nearest_whole_cluster(clusters: list[tuple[float, int]], limit_m: float) -> None:
    points = np.array([[0, 0, 2], [0.4, 0, 2], [0.2, 0.05, 2], [0.2, -0.05, 2]], float)
    depths_m = [np.full(count, depth_m, np.float32) for depth_m, count in clusters]
    assert background_limit_m(depths_m, [points] * len(clusters), 0.3) == pytest.approx(limit_m, abs=1e-5)


def test_masks_without_a_reading_are_no_detections() -> None:
    frame, mask = two_plates(), rectangle(30, 33, 50, 110)  # which shrinking erases
    assert lifted(frame, masks_of(mask), shrink_pixels=8).detections == ()


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
    assert [d.mask for d in found] == [0, 1]
    assert [d.class_name for d in found] == ["plate", "all"]
    assert [d.score for d in found] == pytest.approx([0.4, 0.8])
    assert all(np.array_equal(d.embedding, vectors[d.mask]) for d in found)
    assert [d.quality for d in found] == pytest.approx([0.4 * 900 / 4900, 0.8 * 1600 / 3600 * 1600 / 5600])


def test_an_empty_name_is_none() -> None:
    masks = masks_of(rectangle(45, 75, 65, 95), rectangle(30, 90, 50, 110), names=("", "all"))
    found = lifted(two_plates(), masks, np.stack([unit(1, 0), unit(0, 1)])).detections
    assert [d.class_name for d in found] == [None, "all"]


def test_members_are_the_distinct_cells_of_each_mask() -> None:
    masks = masks_of(rectangle(30, 90, 50, 110), rectangle(0, 60, 0, 80))
    surface, result = look(two_plates()), lifted(two_plates(), masks)
    expected = set()
    for cell, row, column in zip(surface.pixel_cell, surface.rows, surface.columns, strict=True):
        is_wall = surface.depth[row, column] > 1.6  # which lies behind the thing that the first mask is of
        expected |= {(int(cell), n) for n in range(2) if masks.masks[n, row, column] and (n or not is_wall)}
    found = list(zip(result.member_cell.tolist(), result.member_mask.tolist(), strict=True))
    assert found == sorted(expected)


def test_masks_whose_largest_cluster_is_too_small_are_nothing() -> None:
    small = masks_of(rectangle(40, 48, 60, 68))  # 8x8 pixels: 2 x 2 or 3 x 3 cells
    (found,) = lifted(two_plates(), small).detections
    assert 8 <= found.n_cells <= 9
    strict = LIFTING.model_copy(update={"min_cells": 10})
    result = lift(look(two_plates()), small, unit(1, 0)[None], strict, 0)
    assert result.detections == ()
    assert len(result.member_cell) == len(result.member_mask) == 0


@pytest.mark.parametrize(
    ("mask", "expected"),
    [
        (rectangle(30, 90, 20, 80), 0),
        (rectangle(30, 90, 0, 60), 60 / 240),  # a square cut on one side
        (rectangle(60, 120, 100, 160), 120 / 240),  # a square cut at a corner
        (rectangle(0, 120, 40, 60), 40 / 280),  # a pillar from above to below
        (rectangle(0, 120, 0, 160), 1),
    ],
)
def test_a_view_that_the_image_border_cuts_is_trusted_less(mask: np.ndarray, expected: float) -> None:
    frame = frame_of(np.full(SHAPE, 2.0))
    rows, columns = (part.astype(np.int32) for part in np.nonzero(mask))
    assert cut_share(rows, columns, (0, SHAPE[0] - 1, 0, SHAPE[1] - 1)) == pytest.approx(expected)
    (found,) = lifted(frame, masks_of(mask)).detections
    whole = mask.sum() / (mask.sum() + 4000)
    assert found.quality == pytest.approx(whole * (1 - 0.75 * expected))


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
    assert view_quality(score, share, pixels, cut=1.0) == pytest.approx(quality / 4)


def test_depth_that_ends_before_the_image_does_cuts_a_view_all_the_same() -> None:
    """A registered Kinect depth image has no readings in its last columns."""
    depth = np.full(SHAPE, 2.0)
    depth[:, 152:] = 0
    mask = rectangle(30, 90, 100, 160)
    (found,) = lifted(frame_of(depth), masks_of(mask)).detections
    n_pixels = 60 * 52
    assert found.quality == pytest.approx(n_pixels / (n_pixels + 4000) * (1 - 0.75 * 60 / 224))
