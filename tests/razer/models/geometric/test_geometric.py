"""The geometric segmenter on scenes with a known answer, and on real frames with hand-picked places."""

from __future__ import annotations

from pathlib import Path

import cv2
import numpy as np
import pytest

from data_tools import open_sequence
from razer.errors import BadInput
from razer.frame import Frame, Masks
from razer.models import make_segmenter
from razer.models.geometric.segmenter import GeometricSegmenter
from tests.support.depth_scenes import as_from_a_kinect, box, frame_of, plane, scene

FLOOR = plane((0, 0.8, 0.6), 1.6)
WALL = plane((0, -0.6, 0.8), 2.0)
TABLE = plane((0, 0.8, 0.6), 1.1)
SENSORS = [pytest.param(lambda depth: depth, id="ideal"), pytest.param(as_from_a_kinect, id="kinect")]


def owner_of(masks: Masks, region: np.ndarray) -> tuple[int, float]:
    """The mask that covers most of a region, and the share it covers."""
    shares = [(mask & region).sum() / region.sum() for mask in masks.masks]
    return int(np.argmax(shares)), max(shares)


def overlap(mask: np.ndarray, region: np.ndarray) -> float:
    return (mask & region).sum() / (mask | region).sum()


@pytest.mark.parametrize("sensor", SENSORS)
def test_planes_that_meet_in_a_valley_are_two(sensor) -> None:
    depth, shown = scene(np.minimum(FLOOR, WALL))
    shown = np.where(FLOOR < WALL, 0, 1)
    masks = GeometricSegmenter().segment(frame_of(sensor(depth)))
    assert len(masks) == 2
    for surface in (0, 1):
        region = shown == surface
        index, share = owner_of(masks, region)
        assert share > 0.97
        assert overlap(masks.masks[index], region) > 0.95


@pytest.mark.parametrize("sensor", SENSORS)
def test_planes_that_meet_in_a_ridge_are_one(sensor) -> None:
    left, right = plane((0.6, 0, 0.8), 1.2), plane((-0.6, 0, 0.8), 1.2)
    depth, _ = scene(np.maximum(left, right))
    valley, _ = scene(np.minimum(left, right))
    ridge = GeometricSegmenter().segment(frame_of(sensor(depth)))
    assert len(ridge) == 1
    assert ridge.masks[0].mean() > 0.95
    assert len(GeometricSegmenter().segment(frame_of(sensor(valley)))) == 2  # the same two planes, the other way


@pytest.mark.parametrize("sensor", SENSORS)
def test_a_box_on_a_table_is_one_thing_and_the_table_another(sensor) -> None:
    depth, shown = scene(TABLE, box((0.05, -0.02, 1.15), (0.3, 0.25, 0.25), (-37, 30, 0)))
    masks = GeometricSegmenter().segment(frame_of(sensor(depth)))
    assert len(masks) == 2
    assert {owner_of(masks, shown == surface)[0] for surface in (0, 1)} == {0, 1}
    for surface in (0, 1):
        region = shown == surface
        assert overlap(masks.masks[owner_of(masks, region)[0]], region) > 0.9


@pytest.mark.parametrize("sensor", SENSORS)
@pytest.mark.parametrize("distance_m", [0.8, 2.0])
def test_a_depth_step_parts_and_a_step_within_the_noise_does_not(sensor, distance_m: float) -> None:
    left = np.arange(640)[None, :] < 300
    noise_m = GeometricSegmenter().noise_per_m * distance_m**2
    far = np.broadcast_to(np.where(left, distance_m, distance_m + 8 * noise_m), (480, 640))
    near = np.broadcast_to(np.where(left, distance_m, distance_m + 0.5 * noise_m), (480, 640))
    parted = GeometricSegmenter().segment(frame_of(sensor(far)))
    assert len(parted) == 2
    assert overlap(parted.masks[owner_of(parted, np.broadcast_to(left, (480, 640)))[0]], left) > 0.97
    assert len(GeometricSegmenter().segment(frame_of(sensor(near)))) == 1


def test_masks_do_not_overlap_and_scores_are_shares() -> None:
    depth, _ = scene(FLOOR, WALL, box((0, 0, 1.5), (0.3, 0.3, 0.3), (20, 30, 0)))
    masks = GeometricSegmenter().segment(frame_of(as_from_a_kinect(depth)))
    assert masks.masks.sum(axis=0).max() == 1
    assert ((masks.scores > 0) & (masks.scores <= 1)).all()
    assert (masks.masks.sum(axis=(1, 2)) >= 150).all()


def test_without_depth_there_are_no_masks() -> None:
    masks = GeometricSegmenter().segment(frame_of(np.zeros((480, 640))))
    assert masks.masks.shape == (0, 480, 640)


def test_threads_do_not_change_the_answer() -> None:
    depth, _ = scene(FLOOR, WALL, box((0.1, 0, 1.5), (0.3, 0.2, 0.3), (20, 30, 0)))
    frame, threads = frame_of(as_from_a_kinect(depth)), cv2.getNumThreads()
    try:
        answers = []
        for n in (1, 2, 5):
            cv2.setNumThreads(n)
            answers.append(GeometricSegmenter().segment(frame))
    finally:
        cv2.setNumThreads(threads)
    for answer in answers[1:]:
        np.testing.assert_array_equal(answer.masks, answers[0].masks)
        np.testing.assert_array_equal(answer.scores, answers[0].scores)


@pytest.mark.parametrize("shape", [(120, 160), (481, 643), (968, 1296)])
def test_any_image_size_is_covered(shape: tuple[int, int]) -> None:
    depth, _ = scene(np.minimum(FLOOR, WALL))
    small = frame_of(depth)
    camera = small.intrinsics.resized(shape[1], shape[0])
    frame = Frame(
        0,
        0.0,
        cv2.resize(small.rgb, shape[::-1]),
        cv2.resize(depth, shape[::-1], interpolation=cv2.INTER_NEAREST),
        camera,
    )
    masks = GeometricSegmenter().segment(frame)
    assert masks.masks.shape == (2, *shape)
    assert masks.masks.any(axis=0).mean() > 0.97


@pytest.mark.parametrize("options", [{"noise_per_m": 0.0}, {"step": -1.0}, {"concave_deg": float("nan")}])
def test_impossible_options_are_refused(options: dict[str, float]) -> None:
    with pytest.raises(BadInput, match=next(iter(options))):
        make_segmenter("geometric", options)


def polygon(*corners: tuple[int, int]) -> np.ndarray:
    return cv2.fillPoly(np.zeros((480, 640), np.uint8), [np.array(corners)], 1).astype(bool)


@pytest.fixture(scope="module")
def kitchen(real_data: Path):
    return open_sequence(real_data / "redkitchen")


def test_a_kitchen_floor_cabinet_and_chair(kitchen) -> None:
    masks = GeometricSegmenter().segment(kitchen[100])
    floor, floor_share = owner_of(masks, polygon((140, 410), (330, 270), (400, 330), (370, 440), (200, 470)))
    cabinet, cabinet_share = owner_of(masks, polygon((190, 170), (400, 90), (400, 160), (200, 300)))
    rail, rail_share = owner_of(masks, polygon((450, 172), (570, 166), (570, 180), (450, 188)))
    assert min(floor_share, cabinet_share, rail_share) > 0.95
    assert len({floor, cabinet, rail}) == 3


@pytest.mark.parametrize(
    ("index", "table", "cup"),
    [
        (18, [(260, 230), (380, 240), (520, 370), (330, 300)], (400, 185)),
        (325, [(230, 300), (420, 330), (600, 370), (580, 420), (60, 370)], (425, 250)),
    ],
)
def test_a_table_top_is_whole_and_the_cup_on_it_is_not_part_of_it(kitchen, index: int, table, cup) -> None:
    masks = GeometricSegmenter().segment(kitchen[index])
    top, share = owner_of(masks, polygon(*table))
    assert share > 0.95
    on_cup = np.flatnonzero(masks.masks[:, cup[1], cup[0]])
    assert len(on_cup) == 1
    assert on_cup[0] != top
    assert 400 < masks.masks[on_cup[0]].sum() < 4000


def test_a_second_of_kitchen_keeps_its_large_masks(kitchen) -> None:
    """Seen from nearly the same place, a large mask of one frame is found again in the next but one."""
    best_ious = []
    for first in range(280, 290, 2):
        before, after = (GeometricSegmenter().segment(kitchen[i]).masks for i in (first, first + 2))
        for mask in before[before.sum(axis=(1, 2)) > 8000]:
            best_ious.append(max(overlap(mask, other) for other in after))
    assert np.median(best_ious) > 0.85
    assert np.mean(np.array(best_ious) > 0.7) > 0.7
