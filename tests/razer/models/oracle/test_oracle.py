"""The oracle models: exact without noise, and wrong exactly as often and as far as the options say."""

from __future__ import annotations

from concurrent.futures import ThreadPoolExecutor

import cv2
import numpy as np
import pytest
from scipy.optimize import linprog

from razer.errors import BadInput
from razer.frame import Frame, Intrinsics, Masks
from razer.models import make_embedder, make_segmenter
from razer.models.oracle.embedder import OracleEmbedder
from razer.models.oracle.mask_noise import MaskNoise, adjacent_ids
from razer.models.oracle.segmenter import OracleSegmenter

NAMES = ("chair", "table", "lamp", "couch", "cup")


def frame_of(ids: np.ndarray, index: int = 0) -> Frame:
    height, width = ids.shape
    camera = Intrinsics(width, height, 100.0, 100.0, width / 2, height / 2)
    classes = {int(i): NAMES[int(i) % len(NAMES)] for i in np.unique(ids) if i > 0}
    rgb = np.zeros((height, width, 3), np.uint8)
    depth = np.ones((height, width), np.float32)
    return Frame(index, 0.0, rgb, depth, camera, None, ids.astype(np.int32), classes)


def grid(rows: int, columns: int, cell: int, gap: int = 0) -> np.ndarray:
    """Numbered squares of `cell` pixels, `gap` pixels apart, starting with 1."""
    ids = np.zeros((rows * (cell + gap) + gap, columns * (cell + gap) + gap), np.int32)
    for number in range(rows * columns):
        y, x = gap + (number // columns) * (cell + gap), gap + (number % columns) * (cell + gap)
        ids[y : y + cell, x : x + cell] = number + 1
    return ids


APART = grid(5, 6, 12, gap=6)
TOUCHING = grid(5, 6, 12)


def coverage(segmenter: OracleSegmenter, ids: np.ndarray, frames: int) -> np.ndarray:
    """Whether each instance is in some mask, (frames, instances)."""
    rows = []
    for index in range(frames):
        covered = segmenter.segment(frame_of(ids, index)).masks.any(axis=0)
        rows.append([covered[ids == number].any() for number in range(1, ids.max() + 1)])
    return np.array(rows)


def test_without_noise_masks_are_the_ids() -> None:
    ids = np.random.default_rng(0).integers(0, 9, (40, 50)).astype(np.int32)
    frame = frame_of(ids)
    masks = make_segmenter("oracle", {}).segment(frame)
    expected = Masks.from_ids(ids)
    assert np.array_equal(masks.masks, expected.masks)
    assert masks.class_names == tuple(frame.instance_classes[i] for i in range(1, 9))
    assert masks.scores.tolist() == [1.0] * 8


def test_surfaces_are_flagged_as_stuff_where_that_is_asked_for() -> None:
    frame = frame_of(grid(1, 3, 12))
    frame.instance_classes.update({1: "wall", 2: "chair", 3: "floor"})
    assert OracleSegmenter().segment(frame).stuff is None
    masks = OracleSegmenter(stuff=True).segment(frame)
    assert masks.class_names == ("wall", "chair", "floor")
    assert masks.is_stuff.tolist() == [True, False, True]
    with pytest.raises(BadInput, match="has its own errors and stuff"):
        OracleSegmenter(stuff=True, profile="panoptic")


def test_no_instance_in_view_gives_no_masks() -> None:
    assert len(OracleSegmenter("full").segment(frame_of(np.zeros((6, 8), np.int32)))) == 0


def test_instances_without_a_class_are_unknown() -> None:
    frame = frame_of(APART)
    nameless = Frame(0, 0.0, frame.rgb, frame.depth, frame.intrinsics, None, frame.instance_ids)
    assert set(OracleSegmenter().segment(nameless).class_names or ()) == {"unknown"}


@pytest.mark.parametrize(
    "options", [{"noise": "some"}, {"drop": 1.5}, {"split": -0.1}, {"hold": 0}, {"split_frames": 0}, {"jitter_px": 99}]
)
def test_impossible_noise_is_refused(options: dict) -> None:
    with pytest.raises(BadInput):
        make_segmenter("oracle", options)


def test_frames_without_ids_are_refused_in_one_line() -> None:
    frame = frame_of(APART)
    blind = Frame(3, 0.0, frame.rgb, frame.depth, frame.intrinsics)
    with pytest.raises(BadInput, match="frame 3 has no instance ids") as error:
        OracleSegmenter().segment(blind)
    assert "\n" not in str(error.value)


def test_noise_does_not_depend_on_order_or_threads() -> None:
    frames = [frame_of(TOUCHING, index) for index in range(24)]
    one, other = OracleSegmenter("full", 5), OracleSegmenter("full", 5)
    forwards = [one.segment(frame) for frame in frames]
    with ThreadPoolExecutor(4) as pool:
        backwards = list(pool.map(other.segment, frames[::-1]))[::-1]
    for a, b in zip(forwards, backwards, strict=True):
        assert np.array_equal(a.masks, b.masks)
        assert a.class_names == b.class_names
    different = [OracleSegmenter("full", 6).segment(frame) for frame in frames]
    assert not all(np.array_equal(a.masks, b.masks) for a, b in zip(forwards, different, strict=True))


def test_drop_is_a_share_of_masks_independent_from_frame_to_frame() -> None:
    kept = coverage(OracleSegmenter(drop=0.15, seed=1), APART, 150)
    # 4500 draws: three standard deviations are 0.016.
    assert (~kept).mean() == pytest.approx(0.15, abs=0.016)
    both = (~kept[1:] & ~kept[:-1]).mean()
    assert both == pytest.approx(0.15**2, abs=0.009)


def test_hold_keeps_a_mask_away_for_that_many_frames() -> None:
    kept = coverage(OracleSegmenter(drop=0.15, hold=10, seed=2), APART, 400)
    assert (~kept).mean() == pytest.approx(0.15, abs=0.035)
    for instance in kept.T:
        changes = np.flatnonzero(np.diff(instance.astype(int)) != 0)
        assert (np.diff(changes) % 10 == 0).all()


def test_split_cuts_along_a_line_for_five_frames() -> None:
    segmenter = OracleSegmenter(split=0.1, seed=3)
    counts = np.zeros((100, 30), int)
    for index in range(100):
        for mask in segmenter.segment(frame_of(APART, index)).masks:
            instances = np.unique(APART[mask])
            assert len(instances) == 1
            counts[index, instances[0] - 1] += 1
    assert set(np.unique(counts)) == {1, 2}
    # 600 windows: three standard deviations are 0.037.
    assert (counts == 2).mean() == pytest.approx(0.1, abs=0.04)
    for instance in (counts == 2).T:
        changes = np.flatnonzero(np.diff(instance.astype(int)) != 0)
        assert (np.diff(changes) % 5 == 0).all()


def test_the_parts_of_a_split_are_on_two_sides_of_a_line() -> None:
    ids = (cv2.circle(np.zeros((60, 80), np.uint8), (40, 30), 25, 1, -1) > 0).astype(np.int32)
    noise = MaskNoise(seed=4, split=1.0)
    for index in range(0, 60, 5):
        first, second = noise.split_parts(index, 1, ids > 0)
        assert not (first & second).any()
        assert np.array_equal(first | second, ids > 0)
        a, b = (np.argwhere(part).astype(float) for part in (first, second))
        # Find a line w.x + c with w.x + c <= -1 on one side and >= 1 on the other.
        rows = np.concatenate([np.c_[a, np.ones(len(a))], -np.c_[b, np.ones(len(b))]])
        line = linprog(np.zeros(3), A_ub=rows, b_ub=-np.full(len(rows), 1e-3), bounds=[(None, None)] * 3)
        assert line.success


def test_merge_joins_adjacent_pairs() -> None:
    segmenter = OracleSegmenter(merge=0.05, seed=5)
    neighbours = adjacent_ids(TOUCHING)
    n_absorbed = 0
    for index in range(100):
        masks = segmenter.segment(frame_of(TOUCHING, index))
        assert (masks.masks.sum(axis=0) == 1).all()
        for mask, name in zip(masks.masks, masks.class_names or (), strict=True):
            instances = np.unique(TOUCHING[mask]).tolist()
            assert np.array_equal(mask, np.isin(TOUCHING, instances))
            assert len(instances) <= 2
            absorbing = [i for i in instances if set(instances) - {i} <= neighbours[i]]
            assert name in {NAMES[i % len(NAMES)] for i in absorbing}
            n_absorbed += len(instances) - 1
    # 3000 masks: three standard deviations are 0.012; the few without a free neighbour are missing.
    assert n_absorbed / 3000 == pytest.approx(0.05, abs=0.015)


def test_masks_apart_are_never_merged() -> None:
    masks = OracleSegmenter(merge=1.0).segment(frame_of(APART))
    assert np.array_equal(masks.masks, Masks.from_ids(APART).masks)


def test_adjacency_equals_a_pixelwise_reference() -> None:
    ids = np.random.default_rng(1).integers(0, 30, (12, 14)).astype(np.int32)
    expected: dict[int, set[int]] = {}
    for y in range(12):
        for x in range(14):
            for dy, dx in ((0, 1), (1, 0), (0, -1), (-1, 0)):
                if 0 <= y + dy < 12 and 0 <= x + dx < 14:
                    a, b = int(ids[y, x]), int(ids[y + dy, x + dx])
                    if a > 0 and b > 0 and a != b:
                        expected.setdefault(a, set()).add(b)
    assert adjacent_ids(ids) == expected


def test_jitter_moves_borders_both_ways_by_at_most_three_pixels() -> None:
    ids = np.zeros((120, 160), np.int32)
    cv2.circle(ids, (30, 60), 29, 1, -1)
    cv2.rectangle(ids, (70, 0), (159, 119), 2, -1)
    grown = shrunk = 0
    for index in range(20):
        masks = OracleSegmenter(jitter_px=3, seed=6).segment(frame_of(ids, index))
        assert len(masks) == 2
        for number, mask in enumerate(masks.masks, start=1):
            true = (ids == number).astype(np.uint8)
            added, removed = mask & (true == 0), ~mask & (true > 0)
            # Three steps of the 3x3 cross: city-block distance 3.
            outside = cv2.distanceTransform(1 - true, cv2.DIST_L1, 3)
            # Beyond the image the mask goes on: a border of it is no border of the thing.
            inside = cv2.distanceTransform(cv2.copyMakeBorder(true, 4, 4, 4, 4, cv2.BORDER_REPLICATE), cv2.DIST_L1, 3)
            assert outside[added].max(initial=0) <= 3
            assert inside[4:-4, 4:-4][removed].max(initial=0) <= 3
            grown, shrunk = grown + int(added.sum()), shrunk + int(removed.sum())
    assert grown > 500
    assert shrunk > 500
    assert 0.5 < grown / shrunk < 2


def test_full_noise_is_every_part_at_its_stated_value() -> None:
    assert OracleSegmenter("full", 7).noise == MaskNoise(7, 0.15, 1, 0.10, 5, 0.05, 3)
    assert OracleSegmenter("full", drop=0.0, hold=10).noise == MaskNoise(0, 0.0, 10, 0.10, 5, 0.05, 3)
    assert OracleSegmenter().noise == MaskNoise()


def test_without_noise_a_class_is_one_unit_vector() -> None:
    frame = frame_of(APART)
    masks = OracleSegmenter().segment(frame)
    vectors = make_embedder("oracle", {}).embed(frame, masks)
    assert vectors.dtype == np.float32
    assert vectors.shape == (30, 64)
    np.testing.assert_allclose(np.linalg.norm(vectors, axis=1), 1, atol=1e-6)
    names = np.array(masks.class_names)
    same = names[:, None] == names
    cosines = vectors @ vectors.T
    np.testing.assert_allclose(cosines[same], 1, atol=1e-6)
    assert np.abs(cosines[~same]).max() < 0.5
    assert np.abs(OracleEmbedder(seed=1).class_vector("chair") @ OracleEmbedder().class_vector("chair")) < 0.5


def test_noisy_vectors_have_the_stated_cosine_and_share_of_wrong_classes() -> None:
    embedder = OracleEmbedder("full", 2)
    truth = {name: embedder.class_vector(name) for name in NAMES}
    right = total = 0
    for index in range(60):
        frame = frame_of(APART, index)
        masks = OracleSegmenter().segment(frame)
        for name, vector in zip(masks.class_names or (), embedder.embed(frame, masks), strict=True):
            hits = [other for other, center in truth.items() if abs(center @ vector - 0.7) < 1e-5]
            assert len(hits) == 1
            right, total = right + (hits[0] == name), total + 1
    # 1800 draws: three standard deviations are 0.021.
    assert 1 - right / total == pytest.approx(0.1, abs=0.022)


def test_vectors_depend_on_the_mask_not_on_its_place_in_the_list() -> None:
    frame = frame_of(APART, 4)
    masks = OracleSegmenter().segment(frame)
    order = np.random.default_rng(0).permutation(len(masks))[:17]
    embedder = OracleEmbedder("full", 3)
    assert np.array_equal(embedder.embed(frame, masks.select(order)), embedder.embed(frame, masks)[order])


def test_embedder_needs_class_names_and_sane_options() -> None:
    frame = frame_of(APART)
    blind = Frame(3, 0.0, frame.rgb, frame.depth, frame.intrinsics)
    with pytest.raises(BadInput, match="class names"):
        OracleEmbedder().embed(blind, Masks.from_ids(APART))
    # Where the truth is known, nameless masks are what they show.
    named = OracleSegmenter().segment(frame)
    assert np.array_equal(OracleEmbedder().embed(frame, Masks.from_ids(APART)), OracleEmbedder().embed(frame, named))
    for options in ({"cosine": 1.2}, {"wrong_class": -0.1}, {"dimension": 1}, {"noise": "loud"}):
        with pytest.raises(BadInput):
            make_embedder("oracle", options)


def test_a_frame_without_masks_has_no_embeddings():
    frame = Frame(
        0, 0.0, np.zeros((6, 8, 3), np.uint8), np.ones((6, 8), np.float32), Intrinsics(8, 6, 9.0, 9.0, 3.5, 2.5)
    )
    assert OracleEmbedder(dimension=16).embed(frame, Masks.none(6, 8)).shape == (0, 16)
