"""Submap search: which keyframes of other submaps a view may show."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from razer.arrays import Float64Array
from razer.geometry import inverse
from slam.backend.place_recognition import PlaceRecognition
from slam.backend.submaps.merge_hypotheses import MergeHypotheses
from slam.backend.verified_registration import VerifiedRegistration
from slam.backend.view_overlap import near_poses, overlap_of, reading_points
from slam.config import SlamConfig
from slam.frontend.keyframes import Keyframes, LocatedView, View

# A keyframe that a view may show, and where the view would be in front of it (4, 4) as far as that is foreseen.
Candidate = tuple[int, list[Float64Array]]
LOOKED_AT = 12  # places of similar looks whose features are held against a view's, some 4 ms each


@dataclass
class SubmapSearch:
    """Looks where hypotheses lead, and at what looks alike."""

    keyframes: Keyframes
    places: PlaceRecognition
    hypotheses: MergeHypotheses
    registration: VerifiedRegistration
    config: SlamConfig
    _turn: int = 0  # of the places that look alike, the next that a view is compared with

    def next_candidates(self, located: LocatedView) -> list[Candidate]:
        """As `candidates` has them, but of the places that look alike one only, in turn: the views that follow see much
        the same, and what one of them finds leads the others there."""
        found = self.candidates(located, self.config.loop_closure.shortlist)
        foreseen, alike = ([one for one in found if bool(one[1]) is is_led] for is_led in (True, False))
        self._turn += 1
        return foreseen + ([alike[self._turn % len(alike)]] if alike else [])

    def candidates(self, located: LocatedView, shortlist: int) -> list[Candidate]:
        """What keyframes of other submaps a view may show: those that hypotheses lead to, then those that look alike
        and whose features lie as far from each other as the view's, at most `shortlist`, those with most first."""
        submap = located.reference.submap
        candidates: list[Candidate] = []
        for other, other_from_submap in self.hypotheses.expected(submap):
            moved = other_from_submap @ located.reference.world_from_camera @ located.reference_from_camera
            number = self._most_overlapping(located.view, moved, other)
            if number is not None:
                candidates.append((number, [inverse(self.keyframes[number].world_from_camera) @ moved]))
        foreseen = {number for number, _ in candidates}
        others = np.flatnonzero(self.keyframes.submaps() != submap)
        alike = self.places.lookalikes(located.view, others, 0.0, max(LOOKED_AT, shortlist))
        rigid = self._rigid(located.view, [number for number in alike if number not in foreseen])
        return candidates + [(number, []) for number in rigid[:shortlist]]

    def _rigid(self, view: View, numbers: Sequence[int]) -> list[int]:
        """Those of keyframes that features say a view may show, those of most features first."""
        motions = {n: self.registration.rigid_motion(self.keyframes[n], view) for n in numbers}
        shared = {n: motion.n_explained for n, motion in motions.items() if motion is not None}
        return sorted(shared, key=lambda n: -shared[n])

    def _most_overlapping(self, view: View, world_from_camera: Float64Array, submap: int) -> int | None:
        """The keyframe of a submap that sees most of a view at a pose in it, if it is enough."""
        settings, numbers = self.config.loop_closure, np.flatnonzero(self.keyframes.submaps() == submap)
        near = numbers[near_poses(world_from_camera, self.keyframes.poses()[numbers], settings)].tolist()
        points = reading_points(view, self.config.depth.max_depth_m)
        shares = [
            overlap_of(points, self.keyframes[n].view, inverse(self.keyframes[n].world_from_camera) @ world_from_camera)
            for n in near
        ]
        best = int(np.argmax(shares)) if shares else 0
        return near[best] if shares and shares[best] >= settings.min_overlap else None
