"""Motion prior: where neither depth nor features say how a camera moved, it went on as before, as far as hands let it
(constant velocity under accelerations). Only there: a prior everywhere would lag behind each change of pace (solution
remapping, Zhang, Kaess and Singh, *On degeneracy of optimization-based state estimation problems*, ICRA 2016)."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from razer.arrays import Float64Array
from razer.geometry import inverse
from slam.frontend.icp import IcpResult
from slam.pose_edge import EDGE_SHARE
from slam.se3 import exp_se3, turn_rad

# Of a camera carried by hand, standard deviations: m/s^2 and rad/s^2. In three simulated walks past blank walls any of
# 0.5 to 3 m/s^2 left fewer false ties than no prior; which did best differed from walk to walk.
SHIFT_ACCELERATION, TURN_ACCELERATION = 2.0, 3.0


@dataclass(frozen=True)
class MotionPrior:
    """Where a camera is expected to be: target_from_source (4, 4), so many seconds after it was located last."""

    predicted: Float64Array
    gap_s: float

    @property
    def information(self) -> Float64Array:
        """Of a left perturbation (6, 6), rotation and shift, as IcpResult has it."""
        drifted = self.gap_s**2 / 2
        return np.diag(np.repeat([TURN_ACCELERATION * drifted, SHIFT_ACCELERATION * drifted], 3) ** -2.0)

    def carried_on(self, result: IcpResult) -> Float64Array:
        """The motion of a registration, moved towards the expected one where both views together leave it open."""
        offset = self.predicted @ inverse(result.target_from_source)
        away = self.information @ np.concatenate([turn_rad(offset), offset[:3, 3]])
        step = np.linalg.solve(EDGE_SHARE * result.information + self.information, away)
        moved: Float64Array = exp_se3(step) @ result.target_from_source
        return moved
