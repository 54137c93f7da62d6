"""Upper bounds of the IoU: never below the exact one, and tight where they can be."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.testing import assert_allclose

from razer.boxes.iou import box_iou
from razer.boxes.iou_bounds import iou_bounds, tight_iou_bounds
from tests.support.scenes import random_box


@pytest.mark.parametrize("bound", [iou_bounds, tight_iou_bounds])
def test_bounds_are_never_below_what_boxes_share(bound) -> None:
    rng = np.random.default_rng(0)
    boxes = [random_box(rng) for _ in range(400)]
    first, second = np.arange(200), np.arange(200, 400)
    grown = [box.grown(0.02) for box in boxes]
    shared = box_iou(grown[:200], grown[200:])
    assert (bound(boxes, 0.02, first, second) >= shared - 1e-9).all()
    assert (shared > 0.05).sum() > 20  # pairs that say something
    assert (bound(boxes, 0.02, first, second) > 1.2 * shared + 1e-9).any()


def test_the_bound_of_a_box_with_itself_is_exact_along_its_own_axes() -> None:
    rng = np.random.default_rng(0)
    boxes, row = [random_box(rng) for _ in range(50)], np.arange(50)
    assert_allclose(tight_iou_bounds(boxes, 0.0, row, row), 1)
