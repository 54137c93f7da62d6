"""Local map: a view is recognised in front of several keyframes round about, each of which shares too little with it,
where registrations to them say the same.

Whoever comes back from the other side sees a fifth of what any one keyframe shows. One registration by so little may
be anywhere, unless many features agree on it; that two or three lead to one place by chance was not seen.
"""

from __future__ import annotations

from itertools import combinations
from typing import NamedTuple

import numpy as np

from razer.arrays import Float64Array
from razer.geometry import inverse
from slam.backend.submaps.merge_hypotheses import same_motions
from slam.backend.verified_registration import MIN_FEATURES, VerifiedRegistration
from slam.backend.view_overlap import near_poses, overlap_of, reading_points
from slam.config import SlamConfig
from slam.frontend.color_calibration import ColorCalibration
from slam.frontend.icp import IcpResult
from slam.frontend.keyframes import Keyframes, View

MOST_ASKED = 3  # keyframes, some 15 ms each
LEAST_SHARED = 0.1  # of a view, for a keyframe to be asked, and for its registration to count
ALONE_FEATURES = 20  # that agree, for one registration to count by itself; of 1,543 pairs of views apart 15 at most
SAME_M, SAME_DEG = 0.1, 3.0  # by which registrations that say the same differ: they are a few centimetres off each


class Recognised(NamedTuple):
    """The number of a keyframe, and the registration of a view to it."""

    number: int
    result: IcpResult


class LocalMap:
    """Recognises views among the keyframes of a submap that see what they do."""

    def __init__(self, keyframes: Keyframes, registration: VerifiedRegistration, config: SlamConfig) -> None:
        self._keyframes, self._registration = keyframes, registration
        self._settings, self._max_depth_m = config.loop_closure, config.depth.max_depth_m

    def recognise(
        self, submap: int, view: View, world_from_view: Float64Array, calibration: ColorCalibration
    ) -> Recognised | None:
        """The best of the registrations to several keyframes that agree, if together these share enough with a view, or
        else one that many features bear out.

        Args:
            submap: of the keyframes.
            view: the view.
            world_from_view: (4, 4) about where it is, in the world of the submap.
            calibration: the colour camera as known so far.
        """
        registered = [
            Recognised(number, result)
            for number in self._overlapping(submap, view, world_from_view)
            if (result := self._registered(number, view, world_from_view, calibration)) is not None
        ]
        for n in range(len(registered), 1, -1):
            for agreeing in combinations(registered, n):
                if self._are_enough(agreeing):
                    return max(agreeing, key=lambda one: one.result.score)
        sure = [one for one in registered if one.result.n_features >= ALONE_FEATURES]
        return max(sure, key=lambda one: one.result.n_features, default=None)

    def _overlapping(self, submap: int, view: View, world_from_view: Float64Array) -> list[int]:
        """The keyframes that see most of a view."""
        keyframes, points = self._keyframes, reading_points(view, self._max_depth_m)
        numbers = keyframes.of_submap(submap)
        near = numbers[near_poses(world_from_view, keyframes.poses()[numbers], self._settings)].tolist()
        shared = {n: overlap_of(points, keyframes[n].view, self._motion(n, world_from_view)) for n in near}
        seeing = [n for n in near if shared[n] >= LEAST_SHARED]
        return sorted(seeing, key=lambda n: -shared[n])[:MOST_ASKED]

    def _motion(self, number: int, world_from_view: Float64Array) -> Float64Array:
        return inverse(self._keyframes[number].world_from_camera) @ world_from_view

    def _registered(
        self, number: int, view: View, world_from_view: Float64Array, calibration: ColorCalibration
    ) -> IcpResult | None:
        guess = self._motion(number, world_from_view)
        return self._registration.register_in_part(self._keyframes[number], view, guess, calibration, LEAST_SHARED)

    def _are_enough(self, registered: tuple[Recognised, ...]) -> bool:
        """Whether all say the same, and share as much together as one would have to alone."""
        share = sum(one.result.score for one in registered)
        n_features = sum(one.result.n_features for one in registered)
        if share < self._settings.min_overlap or n_features < MIN_FEATURES:
            return False
        poses = [self._keyframes[one.number].world_from_camera @ one.result.target_from_source for one in registered]
        return bool(same_motions(np.stack(poses), np.zeros(3), SAME_M, SAME_DEG).all())
