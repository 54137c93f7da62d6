"""Names on a picture: legible, on or beside what they name, never over each other."""

from __future__ import annotations

from itertools import combinations

import numpy as np
import pytest

from app.pictures.label_layout import MAX_LABELS, middle_of, place_labels

SHAPE = (300, 500)


def size_of(text):
    return 9 * len(text) + 12, 18


def crowd(n, side=14, seed=0):
    """Small squares all over a floor (1), some of which hide others."""
    instances = np.full(SHAPE, -1, np.int32)
    instances[20:280, 20:480] = 1
    rng = np.random.default_rng(seed)
    for number in range(2, n + 2):
        row, column = rng.integers(30, 270 - side), rng.integers(30, 470 - side)
        instances[row : row + side, column : column + side] = number
    return instances


def overlap(a, b):
    return a[0] < b[2] and b[0] < a[2] and a[1] < b[3] and b[1] < a[3]


@pytest.mark.parametrize("seed", range(6))
def test_no_name_covers_another_or_what_another_points_at(seed):
    instances = crowd(24, seed=seed)
    labels = place_labels(instances, {number: f"thing {number}" for number in range(2, 26)}, size_of)
    assert 8 <= len(labels) <= MAX_LABELS
    assert not any(overlap(a.box, b.box) for a, b in combinations(labels, 2))
    for label in labels:
        left, top, right, bottom = label.box
        assert 0 <= left < right < SHAPE[1]
        assert 0 <= top < bottom < SHAPE[0]
        for other in labels:
            if other is not label and other.anchor is not None:
                x, y = other.anchor
                assert not (left <= x < right and top <= y < bottom)
        if label.anchor is not None:
            assert instances[label.anchor[::-1]] == label.instance


def test_a_large_thing_carries_its_name_and_a_small_one_has_a_line():
    instances = np.full(SHAPE, -1, np.int32)
    instances[50:250, 40:260] = 7
    instances[100:116, 330:346] = 9
    large, small = place_labels(instances, {7: "table", 9: "cup"}, size_of)
    assert large.anchor is None
    assert instances[middle_of(large.box)[::-1]] == 7
    assert small.anchor is not None
    assert instances[small.anchor[::-1]] == 9
    left, top, right, bottom = small.box
    assert (instances[top:bottom, left:right] == -1).all()  # beside it there is bare ground


def test_the_most_important_names_are_there_and_no_more_than_fit():
    instances = np.full((40, 500), -1, np.int32)
    for number in range(20):
        instances[5:35, 25 * number : 25 * number + 24] = number + 1
    labels = place_labels(instances, dict.fromkeys((3, 1, *range(4, 21)), "refrigerator"), size_of)
    assert labels[0].instance == 3
    assert 2 <= len(labels) < 8


def test_slivers_hidden_things_and_the_nameless_have_no_label():
    instances = np.full(SHAPE, -1, np.int32)
    instances[50:54] = 1
    instances[100:150, 100:150] = 3
    assert place_labels(instances, {1: "edge", 2: "hidden", 3: ""}, size_of) == []


def test_what_is_taken_stays_free():
    instances = np.full(SHAPE, -1, np.int32)
    instances[240:300, 0:120] = 4
    legend = (0, 230, 150, 300)
    (label,) = place_labels(instances, {4: "box"}, size_of, [legend])
    assert not overlap(label.box, legend)
