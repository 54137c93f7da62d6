"""The motion between two views of a simulated room."""

from __future__ import annotations

import numpy as np

from razer.geometry import inverse
from slam.config import SlamConfig
from slam.frontend.color_calibration import ColorCalibration
from slam.frontend.view_registration import ViewRegistration, is_trusted
from slam.se3 import angle_deg, exp_se3, length_m


def test_two_views_of_a_room_are_brought_together_from_any_guess_nearby(room, views):
    truth = inverse(room[10].pose) @ room[12].pose
    registration = ViewRegistration(SlamConfig())
    for twist in ([0, 0, 0, 0, 0, 0], [0.02, -0.02, 0.01, 0.03, -0.03, 0.02], [-0.03, 0.01, 0.02, -0.04, 0.01, 0.03]):
        guess = exp_se3(np.array(twist)) @ truth
        result = registration.register(views[10], views[12], [guess], ColorCalibration.nominal())
        assert result is not None
        assert is_trusted(result)
        off = inverse(truth) @ result.target_from_source
        assert length_m(off) < 0.006
        assert angle_deg(off) < 0.15
