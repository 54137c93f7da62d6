"""Loop closure: motions between keyframes that do not follow each other, neighbours in space and recognised places."""

from __future__ import annotations

from collections import deque
from collections.abc import Iterable, Iterator
from typing import NamedTuple

import numpy as np

from razer.geometry import inverse
from slam.backend.loop_gate import is_within_uncertainty, plausible
from slam.backend.place_recognition import PlaceRecognition
from slam.backend.pose_graph import PoseGraph
from slam.backend.verified_registration import MIN_FEATURES, VerifiedRegistration
from slam.backend.view_overlap import near_poses, overlap_of, reading_points
from slam.config import SlamConfig
from slam.frontend.color_calibration import ColorCalibration
from slam.frontend.keyframes import Keyframe, Keyframes
from slam.pose_edge import PoseEdge

RECENT = 10  # keyframes before one that tracking itself connects with it: they are no loop
# A pair is measured where the variance between the two, as the graph has it, is at least so many times that of a
# further edge: it then falls to 1 / (1 + MIN_GAIN).
MIN_GAIN = 0.2
MAX_GAIN = 10.0  # of a pair that nothing joins near by
MOST_LOOKED_AT = 36  # keyframes whose overlap with a new one is told, of those in reach the nearest by position


class WaitingPair(NamedTuple):
    """Keyframes a < b, which share of b's view a may see, and whether poses have drifted too far to start from."""

    a: int
    b: int
    share: float = 1.0
    has_drifted: bool = False


class LoopClosure:
    """The pairs of keyframes still to be measured, the most promising first."""

    def __init__(
        self,
        keyframes: Keyframes,
        graph: PoseGraph,
        places: PlaceRecognition,
        registration: VerifiedRegistration,
        config: SlamConfig,
    ) -> None:
        self._keyframes, self._graph, self._places, self._registration = keyframes, graph, places, registration
        self._settings = config.loop_closure
        self._max_depth_m = config.depth.max_depth_m
        self._waiting: deque[WaitingPair] = deque()
        self._queued: set[tuple[int, int]] = set()

    def __len__(self) -> int:
        return len(self._waiting)

    def add(self, keyframe: Keyframe) -> None:
        """Queue what a new keyframe may be measured against: places first, then neighbours."""
        places = self._places_of(keyframe)
        neighbors = sorted(self._neighbors(keyframe, MOST_LOOKED_AT), reverse=True)[: self._settings.max_neighbors]
        is_back = bool(places) or any(gain >= MAX_GAIN * share for gain, share, _ in neighbors)
        drifted = [] if is_back else self._drifted_from(keyframe)
        self._places.add(keyframe.view)
        self._queue(WaitingPair(n, keyframe.number) for n in places)
        self._queue(WaitingPair(n, keyframe.number, has_drifted=True) for n in drifted)
        self._queue(WaitingPair(n, keyframe.number, share) for _, share, n in neighbors)

    def queue_neighbors(self) -> None:
        """Queue the pairs that overlap at the present poses, were not measured yet and would add something: those that
        add most first, as they may make others needless."""
        self._graph.doubt_edges()
        found = [(-gain, n, k.number, share) for k in self._keyframes.all for gain, share, n in self._neighbors(k)]
        self._queue(WaitingPair(a, b, share) for _, a, b, share in sorted(found))

    def queue_pair(self, a: int, b: int) -> None:
        """Queue two keyframes a < b that show the same, unless an edge joins them."""
        if not self._graph.network.joined(a, b):
            self._queue([WaitingPair(a, b)])

    def _queue(self, pairs: Iterable[WaitingPair]) -> None:
        for pair in pairs:
            if pair[:2] not in self._queued:
                self._queued.add(pair[:2])
                self._waiting.append(pair)

    def _places_of(self, keyframe: Keyframe) -> list[int]:
        submaps = self._keyframes.submaps()[: keyframe.number]
        own = np.flatnonzero(submaps[: max(0, keyframe.number - RECENT)] == keyframe.submap)
        others = np.flatnonzero(submaps != keyframe.submap)
        view, settings = keyframe.view, self._settings
        alike = self._places.lookalikes(view, own, settings.min_similarity_sigmas, settings.shortlist)
        return alike + self._places.lookalikes(view, others, 0.0, settings.shortlist)

    def _drifted_from(self, keyframe: Keyframe) -> list[int]:
        """The keyframe in reach that looks most like one which, at poses that have drifted, sees nothing of those that
        no short way leads to, if both may share something: it need not stand out among all."""
        reached = [number for number, gain in self._uncertain(keyframe) if gain >= MAX_GAIN]
        best = self._places.lookalikes(keyframe.view, reached, 0.0, 1)
        return [n for n in best if self._registration.rigid_motion(self._keyframes[n], keyframe.view)]

    def _neighbors(self, keyframe: Keyframe, most: int | None = None) -> Iterator[tuple[float, float, int]]:
        """Earlier keyframes of the same submap whose view overlaps with this one's, and an edge to which would add
        something: how much, the share of the view that they see, their number. At `most` so many are looked at."""
        points = reading_points(keyframe.view, self._max_depth_m)
        for number, gain in self._uncertain(keyframe)[:most]:
            other = self._keyframes[number]
            share = overlap_of(points, other.view, inverse(other.world_from_camera) @ keyframe.world_from_camera)
            if share >= self._settings.min_overlap and share * gain >= MIN_GAIN:
                yield share * gain, share, number

    def _uncertain(self, keyframe: Keyframe) -> list[tuple[int, float]]:
        """Earlier keyframes in reach that are not as good as fixed to this one, the nearest first, with what an edge
        would add if views were the same."""
        keyframes, network = self._keyframes, self._graph.network
        own = np.flatnonzero(keyframes.submaps()[: keyframe.number] == keyframe.submap)
        near = own[near_poses(keyframe.world_from_camera, keyframes.poses()[own], self._settings)].tolist()
        variances, unit = network.variances_from(keyframe.number), network.usual_variance
        gains = [(n, min(variances[n] / unit, MAX_GAIN) if n in variances else MAX_GAIN) for n in near]
        return [(n, gain) for n, gain in gains if gain >= MIN_GAIN and not network.joined(n, keyframe.number)]

    def _adds(self, a: Keyframe, b: Keyframe, share: float) -> bool:
        """Whether an edge between two keyframes would be felt."""
        if a.submap != b.submap:
            return True
        network = self._graph.network
        variance = network.variances_from(a.number).get(b.number)
        return variance is None or share * variance / network.usual_variance >= MIN_GAIN

    def _next(self) -> WaitingPair | None:
        """The next pair that still adds something."""
        while self._waiting:
            pair = self._waiting.popleft()
            if self._adds(self._keyframes[pair.a], self._keyframes[pair.b], pair.share):
                return pair
            self._queued.discard(pair[:2])  # what is near now may not be at other poses
        return None

    def measure_next(self, calibration: ColorCalibration) -> PoseEdge | None:
        """Measure the next pair; None if there is none, or it came to nothing. What contradicts its
        submap's poses is told if features say so, too: these may be wrong."""
        pair = self._next()
        if pair is None:
            return None
        a, b = self._keyframes[pair.a], self._keyframes[pair.b]
        view, known = self._keyframes.view(b), a.submap == b.submap
        guesses = [inverse(a.world_from_camera) @ b.world_from_camera] if known else []
        measure = self._registration.recognise if pair.has_drifted or not known else self._registration.register
        result = measure(a, view, guesses, calibration)
        if result is None:
            return None
        edge = PoseEdge(a.number, b.number, result.target_from_source, result.information)
        return edge if not known or result.n_features >= MIN_FEATURES or self.is_plausible(edge) else None

    def is_plausible(self, edge: PoseEdge) -> bool:
        """Whether an edge fits to where its keyframes are, if they are of one submap, but for drift."""
        a, b = self._keyframes[edge.a], self._keyframes[edge.b]
        return a.submap == b.submap and plausible(a, b, edge.a_from_b, self._settings)

    def may_have_drifted(self, edge: PoseEdge) -> bool:
        """Whether an edge that is not plausible lies within what tracking leaves open of the way between its keyframes,
        if they are of one submap."""
        a, b = self._keyframes[edge.a], self._keyframes[edge.b]
        return a.submap == b.submap and is_within_uncertainty(edge, self._graph)
