"""Frame-to-keyframe odometry with a constant-velocity motion model."""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from typing import TypeGuard

import numpy as np

from razer.arrays import Float64Array, IndexArray
from razer.geometry import inverse
from slam.config import KeyframeSettings
from slam.frontend.color_calibration import ColorCalibration
from slam.frontend.icp import IcpResult
from slam.frontend.keyframes import STILL, Keyframe, Keyframes, View
from slam.frontend.motion_prior import MotionPrior
from slam.frontend.view_registration import ViewRegistration, is_trusted, leaves_open
from slam.se3 import angle_deg, length_m, turn_rad

# Nobody moves a camera faster from one frame to the next, even if every fourth frame alone is used.
MAX_STEP_M, MAX_STEP_DEG = 0.7, 50.0
UNFORESEEN_RAD_S = 0.2  # turning that differs by more from what was predicted is taken into account
MIN_GAP_S, USUAL_GAP_S = 0.005, 1 / 30  # between frames; stamps that are nearer to each other are not times
# How the camera turned from one picture to the next says how it turned while it took them if the time between is short,
# and if it is one: nobody turns a camera faster.
MAX_GAP_S, MAX_TURNING_RAD_S = 0.5, 5.0
# Share of the way after which a keyframe is taken: one that is no farther away serves as long as a new one, nearly.
NEARLY_THERE = 0.6


@dataclass
class FrameTracker:
    """Where the camera is: in front of which keyframe, at which time, and how it moved last (4, 4). `has_prior`:
    whether that decides where views leave the motion open, once `knows_step`, as some view showed it whole."""

    keyframes: Keyframes
    registration: ViewRegistration
    reference: Keyframe
    reference_from_camera: Float64Array
    stamp: float
    step: Float64Array = field(default_factory=lambda: np.eye(4))
    has_prior: bool = True
    knows_step: bool = False

    def predicted(self) -> Float64Array:
        """reference_from_camera if the camera goes on as before."""
        return self.reference_from_camera @ self.step

    def follow(self, view: View, calibration: ColorCalibration) -> tuple[View, IcpResult] | None:
        """Register a further view to the reference; None if it is not where it may be. The view comes back turning as
        it was measured to."""
        reference = self.reference
        matches = self.registration.match(reference.view, view)
        result = self.registration.register(
            self.keyframes.view(reference), view, [self.predicted()], calibration, matches=matches, may_be=self.may_move
        )
        if result is not None:
            result = self._carried_on(result, view, calibration, matches)
        if not self._may_be(result):
            return None
        turning = self._turning(result.target_from_source, view.stamp)
        is_first = not reference.view.turning_rad_s.any()
        if is_first:
            reference.view = reference.view.turning(turning)
        if is_first or np.linalg.norm(turning - view.turning_rad_s) > UNFORESEEN_RAD_S:
            view = view.turning(turning)
            refined = self.registration.refine(
                reference.view, view, result.target_from_source, calibration, matches=matches
            )
            refined = self._carried_on(refined, view, calibration, matches)
            result = refined if self._may_be(refined) else result
        self.knows_step |= not leaves_open(result)
        return view, result

    def _carried_on(
        self, result: IcpResult, view: View, calibration: ColorCalibration, matches: IndexArray
    ) -> IcpResult:
        """A registration of a view to the reference, which the motion so far decides where that leaves it open."""
        if not (self.has_prior and self.knows_step and leaves_open(result)):
            return result
        prior = MotionPrior(self.predicted(), self._gap_s(view.stamp))
        moved = prior.carried_on(result)
        fit = self.registration.fit(self.reference.view, view, moved, calibration, matches)
        return replace(fit, solved_information=fit.solved_information + prior.information)

    def _may_be(self, result: IcpResult | None) -> TypeGuard[IcpResult]:
        return result is not None and is_trusted(result) and self.may_move(result.target_from_source)

    def may_move(self, reference_from_camera: Float64Array) -> bool:
        """Whether anybody moves a camera so far so soon."""
        step = inverse(self.reference_from_camera) @ reference_from_camera
        return length_m(step) <= MAX_STEP_M and angle_deg(step) <= MAX_STEP_DEG

    def turning_rad_s(self, stamp: float) -> Float64Array:
        """How the camera turns (3,), about its own axes, if it goes on as before until the given time."""
        return self._turning(self.predicted(), stamp)

    def _turning(self, reference_from_camera: Float64Array, stamp: float) -> Float64Array:
        gap_s = self._gap_s(stamp)
        turning = turn_rad(inverse(self.reference_from_camera) @ reference_from_camera) / gap_s
        return STILL if gap_s > MAX_GAP_S or np.linalg.norm(turning) > MAX_TURNING_RAD_S else turning

    def _gap_s(self, stamp: float) -> float:
        return stamp - self.stamp if stamp >= self.stamp + MIN_GAP_S else USUAL_GAP_S

    def advance(self, reference_from_camera: Float64Array, stamp: float) -> None:
        """The camera was located, at the time of `stamp`."""
        self.stamp = stamp
        self.step = inverse(self.reference_from_camera) @ reference_from_camera
        self.reference_from_camera = reference_from_camera

    def turn_to(self, reference: Keyframe, reference_from_camera: Float64Array) -> None:
        """From now on register to another keyframe."""
        self.reference, self.reference_from_camera = reference, reference_from_camera


def needs_keyframe(result: IcpResult, settings: KeyframeSettings) -> bool:
    """Whether the camera has moved so far that the reference will soon be of no use."""
    motion = result.target_from_source
    return (
        angle_deg(motion) > settings.max_angle_deg
        or length_m(motion) > settings.max_shift_m
        or result.score < settings.min_score
        or result.agreement < settings.min_agreement
    )


def keyframe_nearby(
    keyframes: Keyframes, reference: Keyframe, reference_from_camera: Float64Array, settings: KeyframeSettings
) -> Keyframe | None:
    """The keyframe nearest to a camera, of those that tracking joins with its reference, as others may be elsewhere;
    None where tracking could not go on from there for long. Who comes back to where he was sees nothing new: a further
    keyframe would cost as much as a place never seen, and count its errors once more as if they were others.

    Args:
        keyframes: all of them.
        reference: the keyframe that the camera was followed from.
        reference_from_camera: (4, 4) where it is.
        settings: when a keyframe is taken.
    """
    numbers = np.flatnonzero(keyframes.chains() == reference.chain)
    numbers = numbers[numbers != reference.number]
    if not len(numbers):
        return None
    away = _shares_of_way(reference.world_from_camera @ reference_from_camera, keyframes.poses()[numbers], settings)
    nearest = int(np.argmin(away))
    return keyframes[int(numbers[nearest])] if away[nearest] <= NEARLY_THERE else None


def _shares_of_way(world_from_camera: Float64Array, poses: Float64Array, settings: KeyframeSettings) -> Float64Array:
    """How far (N,) a camera is from poses (N, 4, 4), of the way after which a keyframe is taken."""
    away = inverse(world_from_camera) @ poses
    shift_m = np.linalg.norm(away[:, :3, 3], axis=1)
    cosine = (np.trace(away[:, :3, :3], axis1=1, axis2=2) - 1) / 2
    turned_deg = np.degrees(np.arccos(cosine.clip(-1, 1)))
    shares: Float64Array = np.maximum(shift_m / settings.max_shift_m, turned_deg / settings.max_angle_deg)
    return shares
