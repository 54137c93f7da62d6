"""The R-tree against a scan over all boxes."""

from __future__ import annotations

import numpy as np

from razer.boxes.oriented_box import OrientedBox
from razer.boxes.rtree_index import SLACK_M, BoxIndex
from tests.support.scenes import axis_box, moved, pose, random_box


def slow_near(boxes: dict[int, OrientedBox], query: OrientedBox, margin_m: float) -> list[int]:
    low, high = np.split(query.enclosing_bounds(margin_m), 2)
    bounds = {i: np.split(box.enclosing_bounds(), 2) for i, box in boxes.items()}
    return [i for i, (a, b) in sorted(bounds.items()) if (a <= high).all() and (b >= low).all()]


def test_every_box_within_the_margin_is_found_and_none_beyond_the_slack() -> None:
    """Through inserts, removals, large moves and many small ones."""
    rng = np.random.default_rng(0)
    index = BoxIndex()
    boxes: dict[int, OrientedBox] = {}
    for step in range(300):
        number = int(rng.integers(1, 60))
        if number in boxes and step % 5 == 0:
            index.drop(number)
            del boxes[number]
        else:
            shift = rng.normal(0, 0.5 if step % 2 else SLACK_M / 4, 3)
            boxes[number] = moved(boxes.get(number, random_box(rng, 3.0)), pose(shift))
            index.put(number, boxes[number])
        query = random_box(rng, 3.0)
        found = index.near(query, 0.1)
        assert found == sorted(set(found))
        assert set(slow_near(boxes, query, 0.1)) <= set(found) <= set(slow_near(boxes, query, 0.1 + 2 * SLACK_M))


def test_a_box_that_creeps_is_not_lost() -> None:
    index = BoxIndex()
    for i in range(200):
        index.put(1, axis_box((i * SLACK_M / 3, 0, 0), (0.1, 0.1, 0.1)))
    assert index.near(axis_box((199 * SLACK_M / 3, 0, 0), (0.1, 0.1, 0.1)), 0.0) == [1]
    assert index.near(axis_box((0, 0, 0), (0.1, 0.1, 0.1)), 0.0) == []


def test_a_dropped_box_is_gone_and_its_id_may_come_back() -> None:
    index, box = BoxIndex(), axis_box((0, 0, 0), (1, 1, 1))
    index.put(4, box)
    index.drop(4)
    assert index.near(box, 1.0) == []
    index.put(4, box)
    assert index.near(box, 0.0) == [4]
