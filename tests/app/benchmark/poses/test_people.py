"""People who cover a third of the view do not lead the camera along."""

from __future__ import annotations

import pytest

from app.benchmark.poses.followed_walk import follow
from app.benchmark.poses.worlds.hard_worlds import WORLDS
from slam.system import SlamSystem


@pytest.mark.full
@pytest.mark.parametrize("seed", [1, 5])
def test_the_camera_is_followed_among_people(seed: int) -> None:
    figures = follow(WORLDS["people"].walk(seed, None), SlamSystem()).figures(5.0)
    assert figures["share_tracked"] == 1
    assert figures["false_ties"] == 0
    assert figures["ate_cm"] < 1
