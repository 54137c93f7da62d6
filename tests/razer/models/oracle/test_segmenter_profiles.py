"""The segmenter profiles err as often and as far as is fixed for them, and do not depend on the order of frames."""

from __future__ import annotations

import warnings
from concurrent.futures import ThreadPoolExecutor

import cv2
import numpy as np
import pytest

from data_tools.synthetic.objects.catalogue import PIECES
from razer.errors import BadInput
from razer.frame import Frame, Masks
from razer.models import make_segmenter
from razer.models.oracle.profiles.confusable_classes import CONFUSABLE, GROUP_OF, SECTOR_FLIPS, said_class
from razer.models.oracle.profiles.detector_profile import DetectorProfile, probability_found
from razer.models.oracle.profiles.mask_shapes import BORDER_SIGMA_PX, signed_distance, strayed
from razer.models.oracle.profiles.panoptic_profile import PanopticProfile
from razer.models.oracle.profiles.table import PROFILES
from razer.models.oracle.profiles.visible_things import VisibleThings, smooth_noise
from tests.support.profile_frames import looking, squares, true_frame

N_FRAMES = 40


def is_of(mask: np.ndarray, truth: np.ndarray) -> bool:
    """Whether a mask was drawn round these pixels."""
    return np.count_nonzero(mask & truth) > 0.75 * np.count_nonzero(mask | truth)


def test_borders_stray_by_a_normal_distance_and_one_in_ten_bleeds():
    rng = np.random.default_rng(0)
    field = smooth_noise((400, 400), 16, rng)
    assert np.std(field) == pytest.approx(1, abs=0.05)
    assert np.std(field[8::16, 8::16]) == pytest.approx(1, abs=0.1), "between knots it varies as much as on them"
    half = np.zeros((400, 40), np.bool_)
    half[:, 20:] = True
    assert signed_distance(half)[5, 18:22].tolist() == [-1.5, -0.5, 0.5, 1.5]
    moved = np.array([20 - strayed(half, rng)[8::16].argmax(axis=1) for _ in range(300)])
    means = moved.mean(axis=1)
    assert np.median(moved.std(axis=1)) == pytest.approx(BORDER_SIGMA_PX, abs=0.3)
    # A tenth is moved outwards as a whole, by 2 px on average.
    assert means.mean() == pytest.approx(0.2, abs=0.1)
    assert (means > 1.2).mean() == pytest.approx(0.1 * 0.7, abs=0.05)


@pytest.mark.parametrize(("cell", "expected"), [(20, 0.214), (28, 0.455), (60, 0.858)])
def test_detector_finds_by_size(cell, expected):
    ids = squares(3, 4, cell, 8)
    assert probability_found(cell**2, False) == pytest.approx(expected, abs=0.01)
    frames = [true_frame(ids, dict.fromkeys(range(1, 13), "box"), index) for index in range(N_FRAMES)]
    found = np.mean([len(DetectorProfile(1).masks(frame)) for frame in frames]) / 12
    assert found == pytest.approx(expected, abs=0.07)


def test_detector_finds_less_of_what_the_border_cuts_and_scores_what_it_finds():
    ids = np.zeros((240, 320), np.int32)
    ids[80:160, :80], ids[80:160, 120:200] = 1, 2
    found = {1: [], 2: []}
    for index in range(400):
        masks = DetectorProfile(2).masks(true_frame(ids, {1: "box", 2: "box"}, index))
        for mask, score in zip(masks.masks, masks.scores, strict=True):
            found[int(ids[mask].max())].append(score)
    whole = probability_found(6400, False)
    # 400 draws: three standard deviations are 0.06.
    assert len(found[2]) / 400 == pytest.approx(whole, abs=0.06)
    assert len(found[1]) / 400 == pytest.approx(0.8 * whole, abs=0.07)
    assert np.mean(found[2]) == pytest.approx(0.3 + 0.6 * whole, abs=0.02)
    assert np.mean(found[1]) == pytest.approx(0.3 + 0.6 * 0.8 * whole, abs=0.02)
    assert np.std(found[2]) == pytest.approx(0.08, abs=0.015)


def test_classes_flip_in_half_of_the_sectors_of_one_thing_in_five():
    ids = np.zeros((60, 80), np.int32)
    ids[20:40, 30:50] = 1
    flipped, sectors = [], []
    frames = [
        true_frame(ids, {1: "chair"}, azimuth, world_from_camera=looking(azimuth)) for azimuth in range(0, 360, 10)
    ]
    views = [VisibleThings.of(frame, "segmenter") for frame in frames]
    for seed in range(300):
        said = [said_class(view, 1, seed, SECTOR_FLIPS) for view in views]
        others = set(said) - {"chair"}
        flipped.append(bool(others))
        if others:
            assert len(others) == 1
            assert others <= set(GROUP_OF["chair"])
            is_other = np.array(said) != "chair"
            assert is_other.mean() == 0.5
            changes = np.flatnonzero(is_other != np.roll(is_other, 1)) * 10
            assert (np.diff(changes) % 60 == 0).all()
            sectors.append(len(changes))
    # 300 draws: three standard deviations are 0.07.
    assert np.mean(flipped) == pytest.approx(0.2, abs=0.07)
    assert max(sectors) > 2, "not always three sectors side by side"


def test_a_flipped_class_scores_less():
    ids = squares(4, 5, 60, 10)
    names = dict.fromkeys(range(1, 21), "cabinet")
    scores = {True: [], False: []}
    for index in range(30):
        frame = true_frame(ids, names, index, world_from_camera=looking(7 * index))
        masks = DetectorProfile(3).masks(frame)
        for score, name in zip(masks.scores, masks.class_names or (), strict=True):
            scores[name == "cabinet"].append(score)
    assert np.mean(scores[True]) - np.mean(scores[False]) == pytest.approx(0.15, abs=0.05)


def test_every_movable_class_of_the_worlds_is_in_one_group():
    names = [name for group in CONFUSABLE for name in group]
    assert len(names) == len(set(names))
    assert set(PIECES) <= set(names)


def test_false_masks_are_three_in_ten_frames_and_last_at_their_place():
    ids = np.ones((60, 80), np.int32)
    names = {1: "wall", 2: "chair"}
    profile = DetectorProfile(4)
    runs: list[int] = []
    total, last = 0, None
    for index in range(1500):
        masks = profile.masks(true_frame(ids, names, index))
        total += len(masks)
        assert set(masks.class_names or ()) <= {"chair"}
        if len(masks) == 1:
            again = last is not None and np.array_equal(last, masks.masks[0])
            runs = [*runs[:-1], runs[-1] + 1] if again and runs else [*runs, 1]
        last = masks.masks[0] if len(masks) == 1 else None
    # 45 patches of 10 frames on average: one standard deviation is 0.045.
    assert total / 1500 == pytest.approx(0.3, abs=0.13)
    assert max(runs) <= 15
    assert np.median([run for run in runs if run > 1]) >= 5


def test_a_false_mask_keeps_its_place_in_the_world_when_the_camera_moves():
    ids, names = np.ones((120, 160), np.int32), {1: "wall", 2: "chair"}
    profile = DetectorProfile(4)
    kept = moved = 0
    for index in range(300):
        here = profile.masks(true_frame(ids, names, index, depth_m=1.9))
        pose = np.eye(4)
        pose[0, 3] = 0.095  # 8 pixels
        there = profile.masks(true_frame(ids, names, index, depth_m=1.9, world_from_camera=pose))
        if len(here) == len(there) == 1:
            shifted = np.roll(here.masks[0], -8, axis=1)
            is_kept = np.count_nonzero(shifted & there.masks[0]) > 0.6 * np.count_nonzero(there.masks[0])
            kept, moved = kept + is_kept, moved + (not is_kept)
    assert kept > 2 * moved
    assert kept > 20


def test_detector_masks_come_from_a_quarter_of_the_resolution():
    ids = (cv2.circle(np.zeros((120, 160), np.uint8), (80, 60), 40, 1, -1) > 0).astype(np.int32)
    ids[58:60] = 0  # a gap of two pixels
    mask = next(m for i in range(9) for m in DetectorProfile(0).masks(true_frame(ids, {1: "box"}, i)).masks)
    assert mask[58:60, 60:100].all(), "a gap of half a prototype pixel is closed"
    assert np.count_nonzero(mask & (ids == 0)) < 0.12 * np.count_nonzero(mask)


def test_hard_detector_hides_things_from_some_sides_and_its_borders_stray():
    ids = squares(1, 1, 80, 40)
    found: dict[int, list[bool]] = {}
    frames = [true_frame(ids, {1: "box"}, i, world_from_camera=looking(10 * i)) for i in range(36)]
    for seed in range(25):
        for frame in frames:
            masks = PROFILES["detector-hard"](seed).masks(frame)
            found.setdefault(seed, []).append(len(masks) > 0)
    rates = np.array([[np.mean(np.roll(f, -s)[:6]) for s in range(0, 36, 3)] for f in found.values()])
    expected = probability_found(6400, False) * (4 + 2 * 0.5) / 6
    assert np.mean(list(found.values())) == pytest.approx(expected, abs=0.06)
    assert (rates.max(axis=1) - rates.min(axis=1)).mean() > 0.4, "from some sides it is missed again and again"


def test_panoptic_gives_every_pixel_one_class_and_joins_what_touches():
    ids = np.full((120, 160), 5, np.int32)
    ids[20:60, 20:60], ids[20:60, 60:100] = 1, 2  # two chairs side by side
    ids[80:110, 20:60] = 3  # and one apart
    ids[80:110, 100:130] = 4
    ids[0, 0] = 0
    names = {1: "chair", 2: "chair", 3: "chair", 4: "lamp", 5: "wall"}
    for index in range(20):
        masks = PanopticProfile(8).masks(true_frame(ids, names, index))
        assert (masks.masks.sum(axis=0) == 1).all()
        large = [mask for mask in masks.masks if np.count_nonzero(mask) > 100]
        assert len(large) == 4
        pair = next(mask for mask in large if mask[40, 40])
        assert pair[40, 80]
        for number, mask in ((3, next(m for m in large if m[95, 40])), (4, next(m for m in large if m[95, 115]))):
            true = (ids == number).astype(np.uint8)
            near = cv2.dilate(true, np.ones((5, 5), np.uint8)) - cv2.erode(true, np.ones((5, 5), np.uint8))
            assert ((mask != (true > 0)) <= (near > 0)).all(), "borders move by at most 2 px"
        assert any((mask != (ids == 4)).any() for mask in large)


def test_hard_panoptic_swallows_small_things_and_is_blotched():
    ids = np.ones((240, 320), np.int32)
    ids[20:50, 20:50], ids[100:220, 100:300] = 2, 3
    names = {1: "wall", 2: "cup", 3: "bed"}
    seen = {2: 0, 3: 0}
    counts = []
    for index in range(60):
        masks = PROFILES["panoptic-hard"](1).masks(true_frame(ids, names, index))
        assert (masks.masks.sum(axis=0) == 1).all()
        counts.append(len(masks))
        for thing in seen:
            seen[thing] += any(is_of(mask, ids == thing) for mask in masks.masks)
    assert seen[3] > 40
    # 900 pixels: found with p 0.15.
    assert seen[2] < 20
    assert np.mean(counts) > 10


@pytest.mark.parametrize("profile", PROFILES)
def test_profiles_do_not_depend_on_order_stride_or_threads(profile):
    ids = squares(2, 3, 40, 0)
    ids[ids == 0] = 7
    names = {1: "chair", 2: "table", 3: "chair", 4: "cup", 5: "wall", 6: "floor", 7: "wall"}
    parts = np.mgrid[: ids.shape[0], : ids.shape[1]][1] // 20 % 3 + 1
    frames = [true_frame(ids, names, i, parts=parts, world_from_camera=looking(9 * i)) for i in range(18)]
    one, other = (make_segmenter("oracle", {"profile": profile, "seed": 5}) for _ in range(2))
    forwards = [one.segment(frame) for frame in frames]
    with ThreadPoolExecutor(3) as pool:
        every_third = list(pool.map(other.segment, frames[::-3]))[::-1]
    assert [same(a, b) for a, b in zip(forwards[2::3], every_third, strict=True)] == [True] * 6
    different = [make_segmenter("oracle", {"profile": profile, "seed": 6}).segment(frame) for frame in frames]
    assert not all(same(a, b) for a, b in zip(forwards, different, strict=True))


def same(a: Masks, b: Masks) -> bool:
    names = a.class_names == b.class_names
    return names and np.array_equal(a.masks, b.masks) and np.array_equal(a.scores, b.scores)


@pytest.mark.parametrize("profile", PROFILES)
def test_a_frame_of_nothing_has_no_masks(profile):
    masks = make_segmenter("oracle", {"profile": profile}).segment(true_frame(np.zeros((40, 60), int), {}))
    assert masks.masks.shape == (0, 40, 60)


def test_a_recording_without_parts_is_said_once_and_has_wholes():
    segmenter = make_segmenter("oracle", {"profile": "sam"})
    ids = squares(3, 4, 60, 24)
    frames = [true_frame(ids, dict.fromkeys(range(1, 13), "chair"), index) for index in range(3)]
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        masks = [segmenter.segment(frame) for frame in frames]
    (warning,) = caught
    assert "no parts/" in str(warning.message)
    assert "\n" not in str(warning.message)
    assert all(is_of(mask, ids == ids[mask].max()) for each in masks for mask in each.masks)


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"profile": "mask-rcnn"}, "no profile 'mask-rcnn': choose from sam, detector"),
        ({"profile": "sam", "noise": "full"}, "leave out noise"),
        ({"profile": "detector", "drop": 0.1}, "leave out noise"),
    ],
)
def test_impossible_profiles_are_one_line(options, message):
    with pytest.raises(BadInput, match=message) as error:
        make_segmenter("oracle", options)
    assert "\n" not in str(error.value)


def test_profiles_need_ids():
    frame = true_frame(np.zeros((40, 60), int), {})
    blind = Frame(3, 0.0, frame.rgb, frame.depth, frame.intrinsics)
    with pytest.raises(BadInput, match="frame 3 has no instance ids"):
        make_segmenter("oracle", {"profile": "panoptic"}).segment(blind)
