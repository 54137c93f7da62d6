"""Recall of things and IoU of surfaces: hand-made frames."""

from __future__ import annotations

import numpy as np
import pytest

from app.mask_quality.recognition import SEEN_PX, SURFACES, THINGS, Recognition
from razer.frame import Masks
from razer.vocabulary import vocabulary
from tests.support.profile_frames import true_frame

HEIGHT, WIDTH = 480, 640
NAMES = {1: "wall", 2: "office chair", 3: "cup", 4: "door", 5: "doorframe"}


def ids_with(boxes: dict[int, tuple[int, int, int, int]]) -> np.ndarray:
    """Ids in boxes (top, left, bottom, right) on a wall."""
    ids = np.ones((HEIGHT, WIDTH), np.int32)
    for number, (top, left, bottom, right) in boxes.items():
        ids[top:bottom, left:right] = number
    return ids


def masks_of(boxes: list[tuple[str, tuple[int, int, int, int]]]) -> Masks:
    masks = np.zeros((len(boxes), HEIGHT, WIDTH), np.bool_)
    for mask, (_, (top, left, bottom, right)) in zip(masks, boxes, strict=True):
        mask[top:bottom, left:right] = True
    return Masks(masks, np.ones(len(boxes), np.float32), tuple(name for name, _ in boxes))


CHAIR, CUP, DOOR, LINING = (100, 100, 300, 200), (50, 400, 90, 440), (0, 500, 400, 600), (0, 600, 400, 620)
FRAME = true_frame(ids_with({2: CHAIR, 3: CUP, 4: DOOR, 5: LINING}), NAMES)


def test_a_thing_is_found_by_a_mask_of_its_class_that_fits() -> None:
    recognition = Recognition()
    recognition.add(FRAME, masks_of([("chair", (100, 100, 260, 200)), ("bowl", CUP)]))
    recognition.add(FRAME, masks_of([("chair", (100, 100, 190, 200)), ("cup", CUP)]))
    result = recognition.to_json()
    assert result["frames"] == 2
    assert result["things"]["chair"] == {"seen": 2, "found": 1}  # the second mask has an IoU of 0.45
    assert result["things"]["cup"] == {"seen": 2, "found": 1}
    assert result["recall"] == pytest.approx(2 / 4)


def test_what_shows_too_little_does_not_count() -> None:
    small = int(np.sqrt(SEEN_PX)) - 1
    frame = true_frame(ids_with({3: (10, 10, 10 + small, 10 + small)}), NAMES)
    recognition = Recognition()
    recognition.add(frame, masks_of([]))
    assert recognition.to_json()["recall"] is None
    # Half as many pixels count in an image of half as many.
    half = true_frame(ids_with({3: (10, 10, 10 + small, 10 + small)})[:, :320], NAMES)
    recognition.add(half, Masks.none(HEIGHT, 320))
    assert recognition.to_json()["things"]["cup"] == {"seen": 1, "found": 0}


def test_surfaces_are_compared_by_pixels_over_all_frames_and_a_lining_is_of_its_door() -> None:
    recognition = Recognition()
    recognition.add(FRAME, masks_of([("door", (0, 500, 400, 560)), ("door", (0, 560, 400, 620))]))
    recognition.add(FRAME, masks_of([("door", (0, 500, 400, 560))]))
    result = recognition.to_json()
    assert result["surfaces"]["door"] == pytest.approx((120 + 60) / (120 + 120))
    assert result["surfaces"]["wall"] == 0
    assert result["surfaces"]["bed"] is None
    assert result["miou"] == pytest.approx((result["surfaces"]["door"] + 0) / 2)


def test_the_classes_are_those_of_the_truth_and_of_models() -> None:
    truth, coco = vocabulary("scannet200").by_name, vocabulary("coco").by_name
    assert len(THINGS) == 15
    for name, words in THINGS.items():
        assert name in coco
        assert words & set(truth)
    for words in SURFACES.values():
        assert words & set(truth)
