"""Motions between keyframes that do not follow each other: neighbours in space, and places seen again."""

from __future__ import annotations

from collections import deque
from collections.abc import Sequence

import numpy as np

from razer.arrays import Float64Array
from razer.geometry import inverse
from slam.backend.free_space_check import contradiction
from slam.backend.place_recognition import PlaceRecognition
from slam.backend.pose_graph import PoseEdge
from slam.frontend.color_calibration import ColorCamera
from slam.frontend.features import Features
from slam.frontend.icp import IcpResult, overlap_of
from slam.frontend.keyframes import Keyframe, Keyframes, View
from slam.frontend.view_registration import MANY_TRIES, TRIES, Grids, is_trusted, register_views
from slam.se3 import angle_deg, length_m

MIN_OVERLAP = 0.3  # share of a view that the other has to see for the two to be measured against each other
MAX_ANGLE_DEG, MAX_AWAY_M = 60.0, 3.0
MAX_NEIGHBOURS = 12  # most overlapping first
SHORTLIST = 3
ALIKE = 0.15  # least likeness of a place worth checking
# The same across submaps: one place from two sides hardly looks alike, and what fits there needs further hypotheses.
ALIKE_AT_ALL = 0.03
MIN_FEATURES = 8  # that agree, where nothing but looks led to the pair
MAX_CONTRADICTION = 0.02
RECENT = 10  # keyframes that tracking itself connects
# What drift may explain; a look-alike place farther off is another place.
DRIFT_M, DRIFT_SHARE, DRIFT_DEG, DRIFT_DEG_PER_M = 0.25, 0.04, 5.0, 1.0


class LoopClosure:
    """The pairs of keyframes still to be measured, the most promising first."""

    def __init__(self, keyframes: Keyframes) -> None:
        self._keyframes = keyframes
        self._places = PlaceRecognition()
        self._waiting: deque[tuple[int, int]] = deque()
        self._asked: set[tuple[int, int]] = set()

    def __len__(self) -> int:
        return len(self._waiting)

    def add(self, keyframe: Keyframe) -> None:
        """Queue what a new keyframe may be measured against: places first, then neighbours."""
        pairs = [(n, keyframe.number) for n in self._places_of(keyframe)]
        pairs += [(n, keyframe.number) for n in self.neighbours(keyframe)]
        self._places.add(keyframe.view.features)
        self._queue(pairs)

    def queue_neighbours(self) -> None:
        """Queue all pairs that overlap at the present poses and were not measured yet."""
        self._queue([(n, k.number) for k in self._keyframes.all for n in self.neighbours(k, limit=None)])

    def _queue(self, pairs: list[tuple[int, int]]) -> None:
        for pair in pairs:
            if pair not in self._asked:
                self._asked.add(pair)
                self._waiting.append(pair)

    def _places_of(self, keyframe: Keyframe) -> list[int]:
        earlier = self._keyframes.all[: keyframe.number]
        own = [k.number for k in earlier[: max(0, keyframe.number - RECENT)] if k.submap == keyframe.submap]
        others = [k.number for k in earlier if k.submap != keyframe.submap]
        found = self.lookalikes(keyframe.view.features, own)
        return found + self.lookalikes(keyframe.view.features, others, ALIKE_AT_ALL)

    def lookalikes(
        self, features: Features, among: Sequence[int], least: float = ALIKE, limit: int = SHORTLIST
    ) -> list[int]:
        """The keyframes, of those with the given numbers, that look most like the features, the most alike first."""
        if not among:
            return []
        numbers = np.array(among)
        alike = self._places.similar(features)[numbers]
        best = np.argsort(-alike, kind="stable")[:limit]
        return [int(numbers[n]) for n in best if alike[n] >= least]

    def neighbours(self, keyframe: Keyframe, limit: int | None = MAX_NEIGHBOURS) -> list[int]:
        """Earlier keyframes of the same submap, but for the one just before, whose view overlaps with this one's."""
        found = []
        grid = self._keyframes.grids(keyframe.number)[0]
        earlier = self._keyframes.all[: max(0, keyframe.number - 1)]
        for other in in_reach(keyframe.world_from_camera, [k for k in earlier if k.submap == keyframe.submap]):
            other_from_this = inverse(other.world_from_camera) @ keyframe.world_from_camera
            share = overlap_of(grid, self._keyframes.grids(other.number)[0], other_from_this)
            if share >= MIN_OVERLAP:
                found.append((-share, other.number))
        return [number for _, number in sorted(found)[:limit]]

    def measure_next(self, camera: ColorCamera) -> PoseEdge | None:
        """Measure the next pair; None if it came to nothing."""
        a, b = (self._keyframes[n] for n in self._waiting.popleft())
        guesses = [inverse(a.world_from_camera) @ b.world_from_camera] if a.submap == b.submap else []
        found = self.seen_from(a, b.view, self._keyframes.grids(b.number), guesses, camera)
        if found is None or (a.submap == b.submap and not plausible(a, b, found.target_from_source)):
            return None
        return PoseEdge(a.number, b.number, found.target_from_source, found.information)

    def seen_from(
        self, keyframe: Keyframe, view: View, grids: Grids, guesses: Sequence[Float64Array], camera: ColorCamera
    ) -> IcpResult | None:
        """A view in front of a keyframe that tracking did not lead to; None where it may be elsewhere as well."""
        tries = TRIES if guesses else MANY_TRIES
        found = register_views(
            keyframe.view, self._keyframes.grids(keyframe.number), view, grids, guesses, camera, tries
        )
        if found is None or not is_trusted(found, MIN_OVERLAP, 40):
            return None
        if not guesses and found.n_features < MIN_FEATURES:
            return None
        against = contradiction(keyframe.view, view, found.target_from_source)
        return found if against <= MAX_CONTRADICTION else None


def in_reach(world_from_camera: Float64Array, keyframes: Sequence[Keyframe]) -> list[Keyframe]:
    """Those whose view may overlap by position and direction, before any point is looked at."""
    if not keyframes:
        return []
    poses = np.stack([keyframe.world_from_camera for keyframe in keyframes])
    away = np.linalg.norm(poses[:, :3, 3] - world_from_camera[:3, 3], axis=1)
    cosine = (poses[:, :3, 2] @ world_from_camera[:3, 2]).clip(-1, 1)
    near = np.flatnonzero((away < MAX_AWAY_M) & (cosine > np.cos(np.radians(MAX_ANGLE_DEG))))
    return [keyframes[int(n)] for n in near]


def plausible(a: Keyframe, b: Keyframe, a_from_b: Float64Array) -> bool:
    """Whether the drift of the way between two keyframes may account for where one is seen from the other."""
    way_m = abs(b.travelled_m - a.travelled_m)
    off = inverse(inverse(a.world_from_camera) @ b.world_from_camera) @ a_from_b
    return length_m(off) <= DRIFT_M + DRIFT_SHARE * way_m and angle_deg(off) <= DRIFT_DEG + DRIFT_DEG_PER_M * way_m
