"""How masks of several segmenters share an image: cases by hand, and what must hold for any masks."""

from __future__ import annotations

import numpy as np
import pytest

from razer.frame import Masks
from razer.models.combined.overlap_rule import RIM_PIXELS, PartMasks, combine

SHAPE = (48, 64)  # a hundredth of 640x480: slivers are of less than 2 pixels, rims of 1 pixel


def box(top: int, left: int, bottom: int, right: int) -> np.ndarray:
    mask = np.zeros(SHAPE, np.bool_)
    mask[top:bottom, left:right] = True
    return mask


def detector(*found: tuple[str, float, np.ndarray]) -> PartMasks:
    return PartMasks(masks_of(*found), tells_instances=True)


def masks_of(*found: tuple[str, float, np.ndarray]) -> Masks:
    masks = np.stack([mask for *_, mask in found]) if found else np.zeros((0, *SHAPE), np.bool_)
    scores = np.array([score for _, score, _ in found], np.float32)
    return Masks(masks, scores, tuple(name for name, *_ in found))


def semantic(*found: tuple[str, np.ndarray]) -> PartMasks:
    masks = masks_of(*((name, 0.5, mask) for name, mask in found))
    stuff = np.array([name in ("wall", "floor") for name, _ in found], np.bool_)
    return PartMasks(Masks(masks.masks, masks.scores, masks.class_names, stuff), tells_instances=False)


def named(masks: Masks) -> list[tuple[str, int]]:
    return [(name, int(m.sum())) for name, m in zip(masks.class_names or (), masks.masks, strict=True)]


def test_things_lie_over_stuff_and_stuff_is_what_is_left() -> None:
    chair, wall = box(10, 10, 30, 20), box(0, 0, 40, 64)
    for parts in ([detector(("chair", 0.6, chair)), semantic(("wall", wall))],
                  [semantic(("wall", wall)), detector(("chair", 0.6, chair))]):  # fmt: skip
        masks = combine(parts, 0.5)
        assert masks.class_names == ("chair", "wall")
        np.testing.assert_array_equal(masks.masks, [chair, wall & ~chair])
        np.testing.assert_array_equal(masks.is_stuff, [False, True])
        np.testing.assert_allclose(masks.scores, [0.6, 0.5])


def test_of_one_thing_that_two_detectors_found_the_better_score_stays() -> None:
    seen, again = box(10, 10, 30, 20), box(10, 10, 30, 21)
    first, second = detector(("chair", 0.6, seen)), detector(("stool", 0.8, again))
    assert combine([first, second], 0.5).class_names == ("stool",)
    assert combine([second, first], 0.5).class_names == ("stool",)
    assert combine([first, second], 0.96).class_names == ("chair", "stool")
    equal = detector(("stool", 0.6, again))
    assert combine([first, equal], 0.5).class_names == ("chair",)
    assert combine([equal, first], 0.5).class_names == ("stool",)


def test_nested_things_stay_whole_and_one_detector_is_left_alone() -> None:
    table, cup = box(10, 10, 40, 60), box(15, 15, 20, 20)
    masks = combine([detector(("table", 0.9, table)), detector(("cup", 0.4, cup))], 0.5)
    np.testing.assert_array_equal(masks.masks, [table, cup])
    twice = detector(("chair", 0.9, table), ("couch", 0.5, table))
    assert combine([twice, detector()], 0.5).class_names == ("chair", "couch")


def test_what_a_thing_encloses_is_no_other_thing_of_a_class_map() -> None:
    """A magazine on a table: the detector leaves it out, the class map does not know it."""
    magazine = box(20, 30, 28, 40)
    table = box(10, 10, 40, 60) & ~magazine
    whole, beside = box(10, 10, 40, 60), box(42, 10, 47, 30)
    masks = combine([detector(("table", 0.9, table)), semantic(("table", whole), ("table", beside))], 0.5)
    assert named(masks) == [("table", int(table.sum())), ("table", int(beside.sum()))]
    hollow = combine([detector(("frame", 0.9, table)), semantic(("picture", magazine))], 0.5)
    assert named(hollow)[1] == ("picture", int(magazine.sum())), "a piece that does not cover the thing is its own"


def test_what_a_suppressed_thing_overlapped_stays() -> None:
    # a beats b, which would beat c: c is compared with what stays.
    a, b, c = box(10, 10, 20, 30), box(10, 13, 20, 33), box(10, 20, 20, 40)
    masks = combine([detector(("a", 0.9, a)), detector(("b", 0.8, b)), detector(("c", 0.7, c))], 0.45)
    assert masks.class_names == ("a", "c")


def test_a_piece_of_a_class_is_left_where_no_thing_is() -> None:
    piece = box(10, 4, 30, 60)  # three chairs that touch, of which the detector found the middle one
    chair = box(10, 24, 30, 40)
    masks = combine([detector(("chair", 0.6, chair)), semantic(("chair", piece))], 0.5)
    rim = round(RIM_PIXELS * SHAPE[0] / 480)
    assert rim == 1
    assert named(masks) == [("chair", 320), ("chair", 20 * (20 - rim)), ("chair", 20 * (20 - rim))]
    assert not masks.is_stuff.any()


def test_the_rim_of_a_thing_is_no_second_one_but_what_stands_behind_is_not_cut() -> None:
    chair = box(10, 10, 30, 20)
    around = box(9, 9, 31, 21)
    masks = combine([detector(("chair", 0.6, chair)), semantic(("chair", around))], 0.5)
    assert named(masks) == [("chair", 200)]
    cabinet = box(5, 5, 35, 40) & ~chair
    masks = combine([detector(("chair", 0.6, chair)), semantic(("cabinet", cabinet))], 0.5)
    assert named(masks) == [("chair", 200), ("cabinet", int(cabinet.sum()))]


def test_of_several_semantic_models_the_first_has_its_pieces_and_things_come_before_stuff() -> None:
    left, right, whole = box(0, 0, 48, 32), box(0, 32, 48, 64), box(0, 0, 48, 64)
    one, other = semantic(("wall", left)), semantic(("floor", whole))
    assert named(combine([one, other], 0.5)) == [("wall", 48 * 32), ("floor", 48 * 32)]
    assert named(combine([other, one], 0.5)) == [("floor", 48 * 64)]
    shelf = semantic(("shelf", right))
    assert named(combine([other, shelf], 0.5)) == [("shelf", 48 * 32), ("floor", 48 * 32)]


def test_masks_without_names_take_them_from_the_classes_beneath() -> None:
    wall, shelf = box(0, 0, 40, 64), box(40, 0, 48, 64)
    picture, panel, box_ = box(10, 10, 20, 20), box(0, 0, 40, 20), box(38, 30, 47, 40)
    found = Masks(np.stack([picture, panel, box_]), np.array([0.9, 0.8, 0.7], np.float32))
    masks = combine([PartMasks(found, tells_instances=True), semantic(("wall", wall), ("shelf", shelf))], 0.5)
    assert masks.class_names == ("", "shelf", "shelf", "shelf", "wall")  # the last shelves: what is left at both sides
    np.testing.assert_array_equal(masks.masks[:2], [picture, box_])
    np.testing.assert_array_equal(masks.masks[4], wall & ~picture & ~box_)
    assert masks.is_stuff.tolist() == [False, False, False, False, True]


def test_stuff_with_fine_borders_comes_before_pieces_of_classes() -> None:
    floor, spilt = box(20, 0, 48, 64), box(0, 0, 26, 64)  # the cupboard's piece covers six rows of the floor
    panel = Masks(floor[None], np.array([0.8], np.float32))
    coarse = semantic(("floor", box(26, 0, 48, 64)), ("cabinet", spilt))
    masks = combine([PartMasks(panel, tells_instances=True), coarse], 0.5)
    assert masks.class_names == ("cabinet", "floor")
    np.testing.assert_array_equal(masks.masks, [box(0, 0, 20, 64), floor])
    assert masks.scores.tolist() == pytest.approx([0.5, 0.8])
    told = Masks(floor[None], np.array([0.8], np.float32), ("floor",), np.array([True]))
    np.testing.assert_array_equal(combine([coarse, PartMasks(told, tells_instances=True)], 0.5).masks, masks.masks)


@pytest.mark.parametrize(("top", "kept"), [(18, True), (8, False)])
def test_a_mask_that_spans_stuff_and_something_else_has_no_say(top: int, kept: bool) -> None:
    mask = box(top, 0, 48, 64)  # of the floor's 24 rows and of the cupboard above it
    parts = [PartMasks(Masks(mask[None], np.ones(1, np.float32)), tells_instances=True),
             semantic(("floor", box(24, 0, 48, 64)), ("cabinet", box(0, 0, 24, 64)))]  # fmt: skip
    masks = combine(parts, 0.5)
    assert masks.class_names == ("cabinet", "floor")
    np.testing.assert_array_equal(masks.masks[1], mask if kept else box(24, 0, 48, 64))


def test_stuff_that_touches_is_one_mask_whatever_lies_before_it() -> None:
    wall = box(0, 0, 40, 64)
    panels = Masks(np.stack([box(0, 0, 40, 30), box(0, 28, 40, 50)]), np.array([0.7, 0.9], np.float32))
    pole = detector(("pole", 0.5, box(0, 40, 48, 44)))  # from top to bottom
    masks = combine([PartMasks(panels, tells_instances=True), pole, semantic(("wall", wall))], 0.5)
    assert named(masks) == [("pole", 48 * 4), ("wall", 40 * 60)]
    assert masks.scores[1] == pytest.approx(0.7)
    apart = semantic(("wall", box(0, 0, 40, 20)), ("wall", box(0, 30, 40, 64)))
    assert named(combine([apart], 0.5)) == [("wall", 40 * 20), ("wall", 40 * 34)]


def test_a_detector_beats_a_segmenter_that_names_nothing_whatever_the_scores() -> None:
    seen, again, beside = box(10, 10, 30, 20), box(10, 10, 30, 21), box(10, 40, 30, 50)
    nameless = Masks(np.stack([again, beside]), np.array([0.99, 0.98], np.float32))
    shelf = semantic(("shelf", box(8, 8, 32, 60)))
    for order in (1, -1):
        parts = [detector(("chair", 0.3, seen)), PartMasks(nameless, tells_instances=True), shelf][::order]
        masks = combine(parts, 0.5)
        by_name = dict(zip(masks.class_names or (), masks.masks, strict=True))
        np.testing.assert_array_equal(by_name["chair"], seen)
        assert any((mask == beside).all() for mask in masks.masks)
        assert not any((mask == again).all() for mask in masks.masks)


def test_what_lies_on_a_thing_does_not_take_its_name() -> None:
    table = box(10, 0, 40, 64)
    top, cup = box(10, 0, 30, 60), box(12, 12, 17, 17)
    found = Masks(np.stack([top, cup]), np.array([0.9, 0.8], np.float32))
    masks = combine([PartMasks(found, tells_instances=True), semantic(("table", table))], 0.5)
    assert (masks.class_names or ())[:2] == ("table", "")


def test_without_a_semantic_model_nothing_is_named() -> None:
    nameless = PartMasks(Masks(box(0, 0, 9, 9)[None], np.ones(1, np.float32)), tells_instances=True)
    assert combine([nameless, nameless], 0.5).class_names is None
    cup = detector(("cup", 0.5, box(20, 20, 30, 30)))
    assert combine([cup, nameless], 0.5).class_names == ("cup", "")


def test_no_masks_at_all_are_none() -> None:
    nothing = PartMasks(Masks.none(*SHAPE), tells_instances=True)
    assert len(combine([nothing, semantic()], 0.5)) == 0


def random_parts(rng: np.random.Generator) -> list[PartMasks]:
    """Two detectors, and a semantic model that gives each pixel a class."""
    parts = []
    for _ in range(2):
        found = []
        for _ in range(rng.integers(0, 5)):
            top, left = rng.integers(0, 40), rng.integers(0, 56)
            size = rng.integers(3, 30, 2)
            found.append(("thing", float(rng.uniform(0.2, 1)), box(top, left, top + size[0], left + size[1])))
        parts.append(detector(*found))
    classes = np.kron(rng.integers(0, 3, (6, 8)), np.ones((8, 8), np.int64))
    return [*parts, semantic(*((name, classes == n) for n, name in enumerate(("wall", "floor", "shelf"))))]


@pytest.mark.parametrize("seed", range(8))
def test_stuff_and_things_share_no_pixel_and_none_of_a_thing_is_lost(seed: int) -> None:
    parts = random_parts(np.random.default_rng(seed))
    masks = combine(parts, 0.5)
    stuff, names = masks.is_stuff, np.array(masks.class_names)
    detected = masks.masks[names == "thing"].any(axis=0)
    pieces = masks.masks[names == "shelf"]
    assert not (masks.masks[stuff].sum(axis=0) > 1).any()
    assert not (masks.masks[stuff].any(axis=0) & masks.masks[~stuff].any(axis=0)).any()
    assert not (pieces.any(axis=0) & detected).any()
    for part in parts[:2]:
        for mask in part.masks.masks:  # as it is, or by a better one that overlaps it
            overlap = [np.count_nonzero(mask & m) / np.count_nonzero(mask | m) for m in masks.masks[names == "thing"]]
            assert max(overlap) > 0.45
    # Stuff is what is left of it, but for slivers and rims.
    wall = parts[2].masks.masks[0]
    left = wall & ~detected
    assert not (masks.masks[names == "wall"].any(axis=0) & ~left).any()
    assert np.count_nonzero(left & ~masks.masks[names == "wall"].any(axis=0)) < 2


def test_the_order_of_masks_in_a_part_changes_nothing() -> None:
    parts = random_parts(np.random.default_rng(3))
    turned = [PartMasks(p.masks.select(np.arange(len(p.masks))[::-1]), p.tells_instances) for p in parts]
    one, other = combine(parts, 0.5), combine(turned, 0.5)
    assert sorted(mask.tobytes() for mask in one.masks) == sorted(mask.tobytes() for mask in other.masks)
