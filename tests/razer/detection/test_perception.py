"""The order of masks is that of their content, whatever the order in which a model lists them."""

from __future__ import annotations

from itertools import permutations

import numpy as np
import pytest

from razer.detection.perception import in_order_of_content
from razer.frame import Masks

# Rows and columns of 6 x 6 pixels, and the score.
LARGE, LOW, HIGH = ((0, 3, 0, 3), 0.5), ((4, 6, 0, 2), 0.9), ((0, 2, 4, 6), 0.9)
SURE, UNSURE = ((4, 6, 4, 6), 0.8), ((4, 6, 4, 6), 0.3)
WIDE, TALL = ((4, 5, 2, 6), 0.9), ((2, 6, 5, 6), 0.9)  # with as many pixels as those, and a corner of theirs


def masks_of(items: tuple[tuple[tuple[int, int, int, int], float], ...]) -> Masks:
    masks = np.zeros((len(items), 6, 6), bool)
    for mask, ((top, bottom, left, right), _) in zip(masks, items, strict=True):
        mask[top:bottom, left:right] = True
    return Masks(masks, np.array([score for _, score in items], np.float32))


@pytest.mark.parametrize(
    "expected", [(LARGE, HIGH, LOW), (LARGE, UNSURE, SURE), (TALL, WIDE, SURE), (HIGH, TALL, LOW, WIDE)]
)
def test_masks_come_by_size_then_by_place_then_by_score(expected: tuple) -> None:
    wanted = masks_of(expected)
    for items in permutations(expected):
        ordered = in_order_of_content(masks_of(items))
        np.testing.assert_array_equal(ordered.masks, wanted.masks)
        np.testing.assert_array_equal(ordered.scores, wanted.scores)
