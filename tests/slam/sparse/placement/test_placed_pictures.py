"""What two pictures say of each other where they would lie is told once for each place."""

from __future__ import annotations

import numpy as np
import pytest

from razer.geometry import inverse
from slam.backend.submaps.placement_check import PlacedPair
from slam.backend.view_checks import color_check, free_space_check
from slam.config import SlamConfig
from slam.frontend.keyframes import Keyframes
from slam.se3 import exp_se3
from slam.sparse.placement.placed_pictures import OFF_M, PlacedPictures

SETTINGS = SlamConfig().free_space


@pytest.fixture
def placed(views):
    keyframes = Keyframes()
    for view in views.values():
        keyframes.add(view, np.eye(4), 0, 0.0)
    return PlacedPictures(keyframes, SETTINGS)


def test_a_pair_tells_what_a_comparison_does_and_compares_once(placed, room, views, monkeypatch):
    motion = inverse(room[10].pose) @ room[12].pose @ exp_se3(np.array([0, 0.1, 0, 0.2, 0, 0]))
    alone = PlacedPair(views[10], views[12], motion, OFF_M)
    expected = alone.contradiction(SETTINGS), alone.color_difference(SETTINGS)
    assert expected[0] > 0
    first = placed.pair(0, 1, motion)
    assert (first.contradiction(SETTINGS), first.color_difference(SETTINGS)) == expected
    monkeypatch.setattr(free_space_check, "reprojected", None)
    monkeypatch.setattr(color_check, "reprojected", None)
    again = placed.pair(0, 1, motion @ exp_se3(np.full(6, 1e-6)))
    assert (again.contradiction(SETTINGS), again.color_difference(SETTINGS)) == expected
    with pytest.raises(TypeError):
        placed.pair(0, 1, motion @ exp_se3(np.array([0, 0, 0, 0.01, 0, 0]))).contradiction(SETTINGS)


def test_other_settings_are_heeded(placed):
    through = exp_se3(np.array([0, 0, 0, 0, 0, 0.3]))
    lenient = SETTINGS.model_copy(update={"margin_m": 5.0})
    pair = placed.pair(0, 1, through)
    assert pair.contradiction(SETTINGS) > pair.contradiction(lenient) == 0
