"""The camera from frame to frame, against a keyframe."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TypeGuard

import numpy as np

from razer.arrays import Float64Array
from razer.geometry import inverse
from slam.frontend.color_calibration import ColorCamera
from slam.frontend.icp import IcpResult
from slam.frontend.keyframes import Keyframe, Keyframes, View
from slam.frontend.view_registration import Grids, is_trusted, refine_registration, register_views
from slam.se3 import angle_deg, length_m, turn_rad

# A new keyframe is taken once the camera has moved so far from the last, or sees so little of it.
KEYFRAME_DEG, KEYFRAME_M, KEYFRAME_SCORE, KEYFRAME_AGREEMENT = 12.0, 0.2, 0.5, 0.65
# Nobody moves a camera faster from one frame to the next, even if every fourth frame alone is used.
MAX_STEP_M, MAX_STEP_DEG = 0.7, 50.0
UNFORESEEN_RAD_S = 0.2  # turning that differs by more from what was foreseen is taken into account
MIN_GAP_S, USUAL_GAP_S, MAX_GAP_S = 0.005, 1 / 30, 0.5  # between frames; stamps that say otherwise are not times


@dataclass
class FrameTracker:
    """Where the camera is: in front of which keyframe, how it moved last."""

    reference: Keyframe
    reference_from_camera: Float64Array
    step: Float64Array
    stamp: float

    def predicted(self) -> Float64Array:
        """reference_from_camera if the camera goes on as before."""
        return self.reference_from_camera @ self.step

    def follow(
        self, view: View, grids: Grids, keyframes: Keyframes, camera: ColorCamera
    ) -> tuple[View, IcpResult] | None:
        """Find a further view in front of the reference; None if it is not where it may be. The view comes back turning
        as it was found to."""
        reference, of_reference = self.reference, keyframes.grids(self.reference.number)
        found = register_views(reference.view, of_reference, view, grids, [self.predicted()], camera)
        if not self._may_be(found):
            return None
        turning = self._turning(found.target_from_source, view.stamp)
        first = not reference.view.turning_rad_s.any()
        if first:
            reference.view = reference.view.turning(turning)
        if first or np.linalg.norm(turning - view.turning_rad_s) > UNFORESEEN_RAD_S:
            view = view.turning(turning)
            again = refine_registration(reference.view, of_reference, view, grids, found.target_from_source, camera)
            found = again if self._may_be(again) else found
        return view, found

    def _may_be(self, found: IcpResult | None) -> TypeGuard[IcpResult]:
        return found is not None and is_trusted(found) and self.may_move(found.target_from_source)

    def may_move(self, reference_from_camera: Float64Array) -> bool:
        """Whether anybody moves a camera so far so soon."""
        step = inverse(self.reference_from_camera) @ reference_from_camera
        return length_m(step) <= MAX_STEP_M and angle_deg(step) <= MAX_STEP_DEG

    def turning_rad_s(self, stamp: float) -> Float64Array:
        """How the camera turns (3,), about its own axes, if it goes on as before until the given time."""
        return self._turning(self.predicted(), stamp)

    def _turning(self, reference_from_camera: Float64Array, stamp: float) -> Float64Array:
        gap_s = stamp - self.stamp
        step = inverse(self.reference_from_camera) @ reference_from_camera
        return turn_rad(step) / (gap_s if MIN_GAP_S <= gap_s <= MAX_GAP_S else USUAL_GAP_S)

    def advance(self, reference_from_camera: Float64Array, stamp: float) -> None:
        """The camera was found, at the time of `stamp`."""
        self.stamp = stamp
        self.step = inverse(self.reference_from_camera) @ reference_from_camera
        self.reference_from_camera = reference_from_camera

    def turn_to(self, reference: Keyframe, reference_from_camera: Float64Array) -> None:
        """From now on measure against another keyframe."""
        self.reference, self.reference_from_camera = reference, reference_from_camera


def needs_keyframe(found: IcpResult) -> bool:
    """Whether the camera has moved so far that the reference will soon be of no use."""
    motion = found.target_from_source
    return (
        angle_deg(motion) > KEYFRAME_DEG
        or length_m(motion) > KEYFRAME_M
        or found.score < KEYFRAME_SCORE
        or found.agreement < KEYFRAME_AGREEMENT
    )
