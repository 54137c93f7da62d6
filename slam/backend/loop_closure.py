"""Loop closure: motions between keyframes that do not follow each other, neighbours in space and recognised places."""

from __future__ import annotations

from collections import deque
from collections.abc import Sequence

import numpy as np

from razer.arrays import Float64Array
from razer.geometry import inverse
from slam.backend.free_space_check import contradiction
from slam.backend.place_recognition import PlaceRecognition
from slam.backend.pose_graph import PoseEdge
from slam.config import LoopClosureSettings, SlamConfig
from slam.frontend.color_calibration import ColorCalibration
from slam.frontend.features import Features
from slam.frontend.icp import IcpResult, overlap_of
from slam.frontend.keyframes import Keyframe, Keyframes, View
from slam.frontend.view_registration import MANY_TRIES, TRIES, ViewRegistration, is_trusted
from slam.se3 import angle_deg, length_m

# Features that agree: enough by themselves where depth does not agree (more than tracking asks for, which has a motion
# model besides), and at least where appearance alone led to the pair.
ENOUGH_FEATURES, MIN_FEATURES = 40, 8
RECENT = 10  # keyframes before one that tracking itself connects with it: they are no loop


class LoopClosure:
    """The pairs of keyframes still to be measured, the most promising first."""

    def __init__(self, keyframes: Keyframes, config: SlamConfig) -> None:
        self._keyframes = keyframes
        self._registration = ViewRegistration(config)
        self._settings, self._free_space = config.loop_closure, config.free_space
        self._places = PlaceRecognition()
        self._waiting: deque[tuple[int, int]] = deque()
        self._queued: set[tuple[int, int]] = set()

    def __len__(self) -> int:
        return len(self._waiting)

    def add(self, keyframe: Keyframe) -> None:
        """Queue what a new keyframe may be measured against: places first, then neighbours."""
        pairs = [(n, keyframe.number) for n in self._places_of(keyframe)]
        pairs += [(n, keyframe.number) for n in self.neighbors(keyframe, self._settings.max_neighbors)]
        self._places.add(keyframe.view.features)
        self._queue(pairs)

    def queue_neighbors(self) -> None:
        """Queue all pairs that overlap at the present poses and were not measured yet."""
        self._queue([(n, k.number) for k in self._keyframes.all for n in self.neighbors(k)])

    def _queue(self, pairs: list[tuple[int, int]]) -> None:
        for pair in pairs:
            if pair not in self._queued:
                self._queued.add(pair)
                self._waiting.append(pair)

    def _places_of(self, keyframe: Keyframe) -> list[int]:
        earlier = self._keyframes.all[: keyframe.number]
        own = [k.number for k in earlier[: max(0, keyframe.number - RECENT)] if k.submap == keyframe.submap]
        others = [k.number for k in earlier if k.submap != keyframe.submap]
        features, settings = keyframe.view.features, self._settings
        return self.lookalikes(features, own, settings.min_similarity, settings.shortlist) + self.lookalikes(
            features, others, settings.min_submap_similarity, settings.shortlist
        )

    def lookalikes(self, features: Features, among: Sequence[int], min_similarity: float, limit: int) -> list[int]:
        """The keyframes whose appearance is most similar to the features', the most similar first.

        Args:
            features: those of the view that is compared.
            among: numbers of the keyframes it is compared with.
            min_similarity: least cosine of their bags of words.
            limit: most keyframes that are returned.
        """
        if not among:
            return []
        numbers = np.array(among)
        similarity = self._places.similarity(features)[numbers]
        best = np.argsort(-similarity, kind="stable")[:limit]
        return [int(numbers[n]) for n in best if similarity[n] >= min_similarity]

    def neighbors(self, keyframe: Keyframe, limit: int | None = None) -> list[int]:
        """Earlier keyframes of the same submap, but for the one just before, whose view overlaps with this one's, the
        most overlapping first."""
        overlapping = []
        grid = self._keyframes.view(keyframe).pyramid.levels[0]
        earlier = [k for k in self._keyframes.all[: max(0, keyframe.number - 1)] if k.submap == keyframe.submap]
        for other in in_reach(keyframe.world_from_camera, earlier, self._settings):
            other_from_this = inverse(other.world_from_camera) @ keyframe.world_from_camera
            share = overlap_of(grid, self._keyframes.view(other).pyramid.levels[0], other_from_this)
            if share >= self._settings.min_overlap:
                overlapping.append((-share, other.number))
        return [number for _, number in sorted(overlapping)[:limit]]

    def measure_next(self, calibration: ColorCalibration) -> PoseEdge | None:
        """Measure the next pair; None if it came to nothing."""
        a, b = (self._keyframes[n] for n in self._waiting.popleft())
        guesses = [inverse(a.world_from_camera) @ b.world_from_camera] if a.submap == b.submap else []
        result = self.register(a, self._keyframes.view(b), guesses, calibration)
        if result is None or (a.submap == b.submap and not plausible(a, b, result.target_from_source, self._settings)):
            return None
        return PoseEdge(a.number, b.number, result.target_from_source, result.information)

    def register(
        self, keyframe: Keyframe, view: View, guesses: Sequence[Float64Array], calibration: ColorCalibration
    ) -> IcpResult | None:
        """Register a view to a keyframe that tracking did not lead to; None where it may be elsewhere as well.

        Args:
            keyframe: what it is registered to.
            view: the view.
            guesses: keyframe_from_view (4, 4) to start from, none where appearance alone led to the pair.
            calibration: the colour camera as known so far.
        """
        tries = TRIES if guesses else MANY_TRIES
        result = self._registration.register(self._keyframes.view(keyframe), view, guesses, calibration, tries)
        if result is None or not is_trusted(result, self._settings.min_overlap, ENOUGH_FEATURES):
            return None
        if not guesses and result.n_features < MIN_FEATURES:
            return None
        against = contradiction(keyframe.view, view, result.target_from_source, self._free_space)
        return result if against <= self._settings.max_contradiction else None


def in_reach(
    world_from_camera: Float64Array, keyframes: Sequence[Keyframe], settings: LoopClosureSettings
) -> list[Keyframe]:
    """Those whose view may overlap by position and direction, before any point is looked at."""
    if not keyframes:
        return []
    poses = np.stack([keyframe.world_from_camera for keyframe in keyframes])
    away = np.linalg.norm(poses[:, :3, 3] - world_from_camera[:3, 3], axis=1)
    cosine = (poses[:, :3, 2] @ world_from_camera[:3, 2]).clip(-1, 1)
    near = np.flatnonzero((away < settings.max_distance_m) & (cosine > np.cos(np.radians(settings.max_angle_deg))))
    return [keyframes[int(n)] for n in near]


def plausible(a: Keyframe, b: Keyframe, a_from_b: Float64Array, settings: LoopClosureSettings) -> bool:
    """Whether the drift of the way between two keyframes may account for a motion measured between them.

    Args:
        a: one keyframe.
        b: the other.
        a_from_b: (4, 4) as measured.
        settings: how much drift there may be.
    """
    way_m = abs(b.travelled_m - a.travelled_m)
    offset = inverse(inverse(a.world_from_camera) @ b.world_from_camera) @ a_from_b
    return (
        length_m(offset) <= settings.drift_m + settings.drift_m_per_m * way_m
        and angle_deg(offset) <= settings.drift_deg + settings.drift_deg_per_m * way_m
    )
