"""The `sam` profile proposes wholes, parts and unions as often as is fixed for it."""

from __future__ import annotations

import numpy as np
import pytest

from razer.frame import Frame
from razer.models.mask_filters import mask_iou
from razer.models.oracle.profiles.sam_profile import SamProfile
from tests.support.profile_frames import squares, true_frame

N_FRAMES = 40


def six_parts(cell: int) -> np.ndarray:
    """Parts 1 to 6 of a square, two columns of three."""
    y, x = np.mgrid[:cell, :cell]
    return 1 + 2 * (3 * y // cell) + 2 * x // cell


def parted_frames(n_frames: int = N_FRAMES) -> list[Frame]:
    """Twelve chairs of six parts of 600 pixels each."""
    ids = squares(3, 4, 60, 24)
    parts = np.zeros_like(ids)
    for thing in range(1, 13):
        y, x = np.argwhere(ids == thing)[0]
        parts[y : y + 60, x : x + 60] = six_parts(60)
    return [true_frame(ids, dict.fromkeys(range(1, 13), "chair"), i, parts=parts) for i in range(n_frames)]


def is_of(mask: np.ndarray, truth: np.ndarray) -> bool:
    """Whether a mask was drawn round these pixels."""
    return np.count_nonzero(mask & truth) > 0.75 * np.count_nonzero(mask | truth)


@pytest.fixture(scope="module")
def sam_counts() -> dict[str, float]:
    """How often each kind of mask is among those of `sam`, for a thing; and scores, and the largest IoU of two."""
    profile = SamProfile(3)
    counts = dict.fromkeys(("whole", "part", "two parts", "three parts"), 0)
    scores, most_iou = [], 0.0
    frames = parted_frames()
    for frame in frames:
        masks = profile.masks(frame)
        assert masks.class_names is None
        assert (np.diff(masks.scores) <= 0).all(), "best first"
        iou = mask_iou(masks.masks)
        most_iou = max(most_iou, float((iou - np.eye(len(iou))).max()))
        scores += masks.scores.tolist()
        for mask in masks.masks:
            covered = (frame.instance_ids * 10 + frame.part_ids)[mask]
            parts, pixels = np.unique(covered[covered > 0], return_counts=True)
            n_parts = int((pixels > 250).sum())  # a part has 600
            assert len({part // 10 for part in parts}) == 1
            assert n_parts in (1, 2, 3, 6), parts
            counts[{1: "part", 2: "two parts", 3: "three parts", 6: "whole"}[n_parts]] += 1
    things = 12 * len(frames)
    shares = {kind: count / things for kind, count in counts.items()}
    return shares | {"score": float(np.mean(scores)), "spread": float(np.std(scores)), "iou": most_iou}


def test_sam_proposes_wholes_parts_and_unions_as_often_as_is_fixed(sam_counts):
    # 480 things: three standard deviations are 0.059, 0.027 of the 2880 parts, and 0.049.
    assert sam_counts["whole"] == pytest.approx(0.75, abs=0.06)
    assert sam_counts["part"] / 6 == pytest.approx(0.6, abs=0.03)
    unions = sam_counts["two parts"] + sam_counts["three parts"]
    assert unions == pytest.approx(0.15, abs=0.05)
    assert min(sam_counts["two parts"], sam_counts["three parts"]) > 0


def test_sam_scores_say_nothing_and_nested_masks_stay(sam_counts):
    assert sam_counts["score"] == pytest.approx(0.88, abs=0.01)
    assert sam_counts["spread"] == pytest.approx(0.06, abs=0.01)
    assert sam_counts["iou"] <= 0.75  # 0.7, told from a quarter of the pixels
    masks = [SamProfile(3).masks(frame).masks for frame in parted_frames(4)]
    nested = 0
    for each in masks:
        flat = each.reshape(len(each), -1).astype(float)
        inside = flat @ flat.T / flat.sum(axis=1)[:, None]
        nested += int((inside > 0.85).sum() - len(each))
    assert nested > 20, "a mask within another is no duplicate"


def test_sam_has_no_parts_of_few_pixels_nor_of_stuff_nor_of_a_thing_of_one_part():
    ids = squares(1, 3, 60, 20)
    ids[ids == 0] = 4
    parts = np.zeros_like(ids)
    parts[20:80, 20:80] = six_parts(60)
    parts[20:24, 20:80] = 7  # 240 pixels of the first thing
    parts[ids == 2] = 1
    parts[ids == 3] = np.arange((ids == 3).sum()) // 900 + 1
    names = {1: "lamp", 2: "lamp", 3: "ceiling", 4: "ceiling"}
    for index in range(30):
        for mask in SamProfile(1).masks(true_frame(ids, names, index, parts=parts)).masks:
            assert not is_of(mask, (ids == 1) & (parts == 7))
            if is_of(mask, mask & (ids == 2)):
                assert is_of(mask, ids == 2)
            if is_of(mask, mask & (ids == 3)):
                assert is_of(mask, ids == 3)


def test_sam_misses_most_of_what_is_small():
    ids = squares(6, 8, 9, 12)  # 81 pixels each
    names = dict.fromkeys(range(1, 49), "cup")
    found = [
        len(SamProfile(2).masks(true_frame(ids, names, index, parts=np.ones_like(ids)))) for index in range(N_FRAMES)
    ]
    # 1920 things, three standard deviations are 0.032; of some nothing is left by the jitter.
    assert np.sum(found) / (48 * N_FRAMES) == pytest.approx(0.75 * 0.4, abs=0.035)


def test_sam_joins_things_that_touch():
    ids = squares(4, 4, 40, 0)
    ids[:, 80:] += 100 * (ids[:, 80:] > 0)
    names = dict.fromkeys(np.unique(ids).tolist(), "lamp")
    joined = 0
    for index in range(N_FRAMES):
        for mask in SamProfile(4).masks(true_frame(ids, names, index, parts=np.ones_like(ids))).masks:
            pixels = np.unique(ids[mask], return_counts=True)[1]
            joined += int((pixels > 800).sum() == 2)
    # 640 things: three standard deviations are 0.026; a pair is chosen from both sides, and then one of two stays.
    assert joined / (16 * N_FRAMES) == pytest.approx(0.05, abs=0.028)


def test_sam_takes_texture_of_walls_floors_and_table_tops_for_things():
    ids = np.ones((240, 320), np.int32)
    ids[120:] = 2
    counts, shares = {"floor": [], "table": []}, []
    parts = np.where(ids == 2, 3, 1)
    for index in range(2 * N_FRAMES):
        masks = SamProfile(5).masks(true_frame(ids, {1: "floor", 2: "ceiling"}, index, parts=parts))
        blobs = [m for m in masks.masks if np.count_nonzero(m) < 0.2 * m.size]
        shares += [np.count_nonzero(m) / m.size for m in blobs]
        counts["floor"].append(len(blobs))
        assert all(np.count_nonzero(m & (ids == 1)) > 0.7 * np.count_nonzero(m) for m in blobs)
    # Half of 3 +- 2 rounded, none below 0: 1.53 on average, of which some overlap by more than 0.7.
    assert np.mean(counts["floor"]) == pytest.approx(1.53, abs=0.4)
    # Borders stray by a pixel or two.
    assert (min(shares), max(shares)) == (pytest.approx(0.005, abs=0.003), pytest.approx(0.03, abs=0.006))
    # A table's top is its highest part.
    parts = np.where(np.mgrid[:240, :320][0] < 90, 1, 2)
    for index in range(20):
        masks = SamProfile(5).masks(true_frame(np.ones_like(ids), {1: "desk"}, index, parts=parts))
        blobs = [m for m in masks.masks if np.count_nonzero(m) < 0.05 * m.size]
        counts["table"].append(len(blobs))
        assert all(np.count_nonzero(m & (parts == 1)) > 0.8 * np.count_nonzero(m) for m in blobs)
    assert sum(counts["table"]) > 10
