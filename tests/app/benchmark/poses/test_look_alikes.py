"""Rooms that look alike are not taken for each other, and what leaves the poses open makes none that are nowhere."""

from __future__ import annotations

import numpy as np
import pytest

from app.benchmark.poses.followed_walk import FollowedWalk, follow
from app.benchmark.poses.worlds.hard_worlds import WORLDS
from slam.system import SlamSystem

pytestmark = pytest.mark.full


def followed(world: str, seed: int = 1) -> FollowedWalk:
    return follow(WORLDS[world].walk(seed, None), SlamSystem())


def test_a_camera_that_comes_to_in_the_twin_of_a_room_is_found_when_it_is_back_in_the_hall() -> None:
    walk = followed("blind-between-twins")
    figures = walk.figures(5.0)
    assert figures["false_ties"] == 0
    assert figures["share_tracked"] > 0.95
    assert figures["ate_cm"] < 15


@pytest.fixture(scope="module", params=[1, 2])
def blank_walls(request: pytest.FixtureRequest) -> FollowedWalk:
    return followed("blank-walls", request.param)


def test_around_a_corridor_with_blank_walls_poses_are_true_where_there_are_any_and_say_what_is_open(
    blank_walls: FollowedWalk,
) -> None:
    graph, figures = blank_walls.slam.report().graph, blank_walls.figures(5.0)
    assert figures["ate_cm"] < 15
    assert figures["false_ties"] <= 2
    assert figures["share_tracked"] > 0.6
    assert graph is not None
    assert np.isfinite(graph.world_from_camera).all()
    assert graph.open
