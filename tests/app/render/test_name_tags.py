"""Names on the image of a map stand on their instances, legibly."""

from __future__ import annotations

import numpy as np

from app.render.name_tags import write_names

SHAPE = (120, 200)


def written_pixels(image: np.ndarray) -> np.ndarray:
    return (image < 60).all(axis=2)  # the letters, which are black, on a ground of 90


def blank() -> np.ndarray:
    return np.full((*SHAPE, 3), 90, np.uint8)


def test_a_name_stands_on_its_instance_though_its_middle_is_elsewhere() -> None:
    instances = np.zeros(SHAPE, np.int32)
    instances[:, :70] = instances[:30] = 4  # the median of its pixels lies in the other
    instances[60:110, 80:190] = 9
    image = blank()
    assert write_names(image, instances, {4: "floor", 9: "chair"}) == [4, 9]
    letters = written_pixels(image)
    assert letters[instances == 4].sum() > 20
    assert letters[instances == 9].sum() > 20
    assert not letters[instances == 0].any()


def test_slivers_and_what_is_not_seen_have_no_name() -> None:
    instances = np.zeros(SHAPE, np.int32)
    instances[50:54] = 1
    image = blank()
    assert write_names(image, instances, {1: "edge", 2: "hidden", 3: ""}) == []
    assert (image == 90).all()


def test_names_give_way_to_earlier_ones_by_a_line_and_then_are_left_out() -> None:
    instances = np.zeros(SHAPE, np.int32)
    for number in range(6):  # side by side, each narrower than its name
        instances[40:80, 60 + 12 * number : 72 + 12 * number] = number + 1
    names = dict.fromkeys((2, 3, 1, 4, 5, 6), "refrigerator")
    written = write_names(blank(), instances, names)
    assert written[:3] == [2, 3, 1]
    assert 3 <= len(written) < 6


def test_names_stay_in_the_image() -> None:
    instances = np.zeros(SHAPE, np.int32)
    instances[:14, :14], instances[-14:, -14:] = 1, 2
    image = blank()
    assert write_names(image, instances, {1: "wardrobe", 2: "armchair"}) == [1, 2]
    letters = written_pixels(image)
    inner = letters[1:-1, 1:-1]
    assert letters.sum() == inner.sum() > 100
