"""Submap search: which keyframes of other submaps a view may show, and which it shows."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from razer.arrays import Float64Array
from razer.geometry import inverse
from slam.backend.place_recognition import PlaceRecognition
from slam.backend.submaps.local_map import LEAST_SHARED, LocalMap, Recognised
from slam.backend.submaps.merge_hypotheses import MergeHypotheses
from slam.backend.verified_registration import VerifiedRegistration
from slam.backend.view_overlap import near_poses, overlap_of, reading_points
from slam.config import SlamConfig
from slam.frontend.color_calibration import ColorCalibration
from slam.frontend.keyframes import Keyframe, Keyframes, LocatedView, View
from slam.pose_edge import PoseEdge

LOOKED_AT = 12  # places of similar looks whose features are held against a view's, some 4 ms each


class Candidate(NamedTuple):
    """A keyframe that a view may show.

    Attributes:
        number: the keyframe's.
        motion: (4, 4) keyframe_from_view as hypotheses, or features, have it.
        is_foreseen: whether hypotheses lead there.
        is_hint: whether so few features do that it may be chance.
    """

    number: int
    motion: Float64Array
    is_foreseen: bool = False
    is_hint: bool = False

    @property
    def guesses(self) -> list[Float64Array]:
        """Where a registration starts from, besides what features say."""
        return [self.motion] if self.is_foreseen else []


@dataclass
class SubmapSearch:
    """Looks where hypotheses lead, and at what looks alike."""

    keyframes: Keyframes
    places: PlaceRecognition
    hypotheses: MergeHypotheses
    registration: VerifiedRegistration
    local_map: LocalMap
    config: SlamConfig
    _turn: int = 0  # of the places that look alike, the next that a view is compared with

    def next_candidates(self, located: LocatedView) -> list[Candidate]:
        """As `candidates` has them, but of the places that look alike one only, in turn: the views that follow see much
        the same, and what one of them finds leads the others there."""
        found = self.candidates(located, self.config.loop_closure.shortlist)
        foreseen = [one for one in found if one.is_foreseen]
        alike = [one for one in found if not one.is_foreseen]
        self._turn += 1
        return foreseen + ([alike[self._turn % len(alike)]] if alike else [])

    def candidates(self, located: LocatedView, shortlist: int) -> list[Candidate]:
        """What keyframes of other submaps a view may show: those that hypotheses lead to, then those that look alike
        and whose features lie as far from each other as the view's, at most `shortlist`, those with most first;
        else the one of which some do."""
        submap = located.reference.submap
        candidates: list[Candidate] = []
        for other, other_from_submap in self.hypotheses.expected(submap):
            moved = other_from_submap @ located.reference.world_from_camera @ located.reference_from_camera
            number = self._most_overlapping(located.view, moved, other)
            if number is not None:
                motion = inverse(self.keyframes[number].world_from_camera) @ moved
                candidates.append(Candidate(number, motion, is_foreseen=True))
        foreseen = {candidate.number for candidate in candidates}
        others = np.flatnonzero(self.keyframes.submaps() != submap)
        alike = self.places.lookalikes(located.view, others, 0.0, max(LOOKED_AT, shortlist))
        rigid = self._rigid(located.view, [number for number in alike if number not in foreseen])
        return candidates + ([one for one in rigid if not one.is_hint][:shortlist] or rigid[:1])

    def _rigid(self, view: View, numbers: Sequence[int]) -> list[Candidate]:
        """Those of keyframes that features say a view may show, those of most features first."""
        motions = {n: self.registration.rigid_motion(self.keyframes[n], view, hints=True) for n in numbers}
        found = {n: motion for n, motion in motions.items() if motion is not None}
        by_features = sorted(found, key=lambda n: -found[n].n_explained)
        return [Candidate(n, found[n].target_from_source, is_hint=not found[n].is_sure) for n in by_features]

    def _most_overlapping(self, view: View, world_from_camera: Float64Array, submap: int) -> int | None:
        """The keyframe of a submap that sees most of a view at a pose in it, if it sees some."""
        settings, numbers = self.config.loop_closure, self.keyframes.of_submap(submap)
        near = numbers[near_poses(world_from_camera, self.keyframes.poses()[numbers], settings)].tolist()
        points = reading_points(view, self.config.depth.max_depth_m)
        shares = [
            overlap_of(points, self.keyframes[n].view, inverse(self.keyframes[n].world_from_camera) @ world_from_camera)
            for n in near
        ]
        best = int(np.argmax(shares)) if shares else 0
        return near[best] if shares and shares[best] >= LEAST_SHARED else None

    def recognised(
        self, located: LocatedView, candidates: Sequence[Candidate], calibration: ColorCalibration
    ) -> Iterator[tuple[PoseEdge, float]]:
        """Edges between those that a view shows and its own keyframe, and how well the view fits.

        Args:
            located: the view.
            candidates: what it may show.
            calibration: the colour camera as known so far.
        """
        found: list[tuple[int, Float64Array]] = []
        for candidate in candidates:
            if self._shows_found(self.keyframes[candidate.number], found):
                continue
            recognised = self._recognised(candidate, located.view, calibration)
            if recognised is None:
                continue
            number, result = recognised
            keyframe = self.keyframes[number]
            found.append((keyframe.submap, keyframe.world_from_camera @ result.target_from_source))
            number_from_reference = result.target_from_source @ inverse(located.reference_from_camera)
            edge = PoseEdge.between(number, located.reference.number, number_from_reference, result.information)
            yield edge, result.score

    def _recognised(self, candidate: Candidate, view: View, calibration: ColorCalibration) -> Recognised | None:
        """A view in front of a keyframe, or of others round about that share enough with it only together."""
        keyframe = self.keyframes[candidate.number]
        if not candidate.is_hint:
            result = self.registration.recognise(keyframe, view, candidate.guesses, calibration)
            if result is not None:
                return Recognised(candidate.number, result)
        world_from_view = keyframe.world_from_camera @ candidate.motion
        return self.local_map.recognise(keyframe.submap, view, world_from_view, calibration)

    def _shows_found(self, keyframe: Keyframe, found: Sequence[tuple[int, Float64Array]]) -> bool:
        """Whether a keyframe shows a place where a view, by the submaps and poses (4, 4) in them where it was found,
        lies: it would say the same once more."""
        return any(
            submap == keyframe.submap
            and len(near_poses(pose, keyframe.world_from_camera[None], self.config.loop_closure)) > 0
            for submap, pose in found
        )
