"""The motion between two views of a simulated room."""

from __future__ import annotations

import numpy as np

from razer.geometry import inverse
from slam.frontend.color_calibration import ColorCamera
from slam.frontend.view_registration import is_trusted, register_views
from slam.se3 import angle_deg, exp_se3, length_m


def test_two_views_of_a_room_are_brought_together_from_any_guess_nearby(room, views):
    truth = inverse(room[10].pose) @ room[12].pose
    grids = {i: view.grids() for i, view in views.items()}
    for twist in ([0, 0, 0, 0, 0, 0], [0.02, -0.02, 0.01, 0.03, -0.03, 0.02], [-0.03, 0.01, 0.02, -0.04, 0.01, 0.03]):
        guess = exp_se3(np.array(twist)) @ truth
        found = register_views(views[10], grids[10], views[12], grids[12], [guess], ColorCamera.nominal())
        assert found is not None
        assert is_trusted(found)
        off = inverse(truth) @ found.target_from_source
        assert length_m(off) < 0.006
        assert angle_deg(off) < 0.15
