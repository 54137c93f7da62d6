"""View novelty: views along a path by hand, and that they do not depend on the frame rate."""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np
import pytest

from razer.tracking.evidence.view_novelty import ViewNovelty
from tests.support.scenes import pose


def novelties(poses: Iterable[np.ndarray]) -> list[float]:
    novelty = ViewNovelty()
    return [novelty.of(world_from_camera) for world_from_camera in poses]


def test_steps_by_hand() -> None:
    """15 cm or 10 degrees are a view, both add up, and no frame is more than one."""
    path = [pose(), pose((0.06, 0, 0)), pose((0.06, 0, 0), (0, 4, 0)), pose((0.06, 0, 0), (0, 40, 0)), pose((9, 0, 0))]
    assert novelties(path) == pytest.approx([1, 0.4, 0.4, 1, 1])


@pytest.mark.parametrize("step_m", [0.15, 0.1, 0.05, 0.01])
def test_a_straight_walk_has_as_many_views_as_it_is_long(step_m: float) -> None:
    path = [pose((x, 0, 0)) for x in np.arange(0, 12.0001, step_m)]
    assert sum(novelties(path)) == pytest.approx(1 + 12 / 0.15, rel=0.03)


def test_frames_farther_apart_than_a_view_are_one_each() -> None:
    assert novelties(pose((0.5 * i, 0, 0), (0, 30 * i, 0)) for i in range(9)) == [1.0] * 9


def test_a_turn_on_the_spot_counts_its_angle() -> None:
    path = [pose((0, 0, 0), (0, angle, 0)) for angle in np.arange(0, 90.1, 2.5)]
    assert sum(novelties(path)) == pytest.approx(1 + 9)


def test_staying_at_a_place_is_one_view_more_at_most() -> None:
    rest = novelties([pose()] * 2000)
    assert rest[1] == pytest.approx(0.05)
    assert (np.diff(rest) <= 1e-12).all()
    assert sum(rest) == pytest.approx(2)


def test_a_trembling_hand_stays_where_it_is() -> None:
    rng = np.random.default_rng(0)
    poses = [pose(rng.normal(0, 0.005, 3), rng.normal(0, 0.3, 3)) for _ in range(2000)]
    assert sum(novelties(poses)) == pytest.approx(2, abs=0.1)


def test_having_stayed_does_not_make_the_way_on_longer() -> None:
    path = [pose()] * 200 + [pose((x, 0, 0)) for x in np.arange(0, 1.501, 0.01)]
    assert sum(novelties(path)) == pytest.approx(1 + 10, abs=0.1)


def test_the_axes_of_the_world_do_not_matter() -> None:
    turned = pose((3, -1, 2), (20, 50, -70))
    path = [pose((0.05 * i, 0.02 * i * i, 0), (0, 3 * i, i)) for i in range(12)]
    assert novelties(turned @ p for p in path) == pytest.approx(novelties(path))
