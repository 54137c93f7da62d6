"""Which pairs of keyframes may be the same place."""

from __future__ import annotations

import numpy as np

from slam.backend.loop_closure import plausible
from slam.config import LoopClosureSettings
from slam.frontend.keyframes import Keyframe
from slam.se3 import exp_se3


def test_a_lookalike_farther_off_than_drift_explains_is_another_place(views):
    def keyframe(number, x_m, travelled_m):
        return Keyframe(number, 0, views[10], exp_se3(np.array([0, 0, 0, x_m, 0, 0])), travelled_m)

    settings = LoopClosureSettings()
    near, far = keyframe(30, 0.3, 12.0), keyframe(31, 3.0, 12.0)
    assert plausible(keyframe(0, 0.0, 0.0), near, np.eye(4), settings)
    assert not plausible(keyframe(0, 0.0, 0.0), far, np.eye(4), settings)
