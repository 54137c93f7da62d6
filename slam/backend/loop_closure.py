"""Loop closure: motions between keyframes that do not follow each other, neighbours in space and recognised places."""

from __future__ import annotations

from collections import deque
from collections.abc import Sequence

import numpy as np

from razer.arrays import Float64Array
from razer.geometry import inverse
from slam.backend.color_check import color_correlation
from slam.backend.free_space_check import contradiction
from slam.backend.place_recognition import PlaceRecognition
from slam.backend.pose_graph import PoseEdge
from slam.config import LoopClosureSettings, SlamConfig
from slam.frontend.color_calibration import ColorCalibration
from slam.frontend.icp import IcpResult, overlap_of
from slam.frontend.keyframes import Keyframe, Keyframes, View
from slam.frontend.view_registration import ViewRegistration, is_trusted
from slam.se3 import angle_deg, length_m

# Features that agree: enough by themselves where depth does not agree (more than tracking asks for, which has a motion
# model besides), and at least where appearance alone led to the pair.
ENOUGH_FEATURES, MIN_FEATURES = 40, 8
LOCAL_MAP = 2  # keyframes by words, and by ferns, that a camera that was just lost is looked for in front of
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
        self._places.add(keyframe.view)
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
        view, settings = keyframe.view, self._settings
        return self.lookalikes(view, own, settings.min_similarity_sigmas, settings.shortlist) + self.lookalikes(
            view, others, 0.0, settings.shortlist
        )

    def lookalikes(self, view: View, among: Sequence[int], min_sigmas: float, limit: int) -> list[int]:
        """The keyframes among those numbered that a view may show again, as PlaceRecognition has them."""
        return self._places.lookalikes(view, among, min_sigmas, limit)

    def neighbors(self, keyframe: Keyframe, limit: int | None = None) -> list[int]:
        """Earlier keyframes of the same submap, but for the one just before, whose view overlaps with this one's, the
        most overlapping first."""
        earlier = [k for k in self._keyframes.all[: max(0, keyframe.number - 1)] if k.submap == keyframe.submap]
        view = self._keyframes.view(keyframe)
        return [k.number for k in self._overlapping(view, keyframe.world_from_camera, earlier)[:limit]]

    def most_overlapping(
        self, view: View, world_from_camera: Float64Array, submap: int, limit: int = 1
    ) -> list[Keyframe]:
        """The keyframes of a submap whose views overlap most with a view at a pose.

        Args:
            view: the view.
            world_from_camera: (4, 4) its pose in the submap.
            submap: the submap.
            limit: most keyframes that are returned.
        """
        among = [k for k in self._keyframes.all if k.submap == submap]
        return self._overlapping(view, world_from_camera, among)[:limit]

    def alike_around(self, view: View, world_from_camera: Float64Array, keyframe: Keyframe) -> list[Keyframe]:
        """Keyframes of a keyframe's submap about a pose, without itself, that look like a view.

        Args:
            view: the view.
            world_from_camera: (4, 4) about where it was taken.
            keyframe: the keyframe that is left out.
        """
        same = [k for k in self._keyframes.all if k.submap == keyframe.submap and k is not keyframe]
        near = [k.number for k in in_reach(world_from_camera, same, self._settings)]
        return [self._keyframes[number] for number in self.lookalikes(view, near, 0.0, LOCAL_MAP)]

    def _overlapping(self, view: View, world_from_camera: Float64Array, among: Sequence[Keyframe]) -> list[Keyframe]:
        grid, overlapping = view.pyramid.levels[0], []
        for other in in_reach(world_from_camera, among, self._settings):
            other_from_view = inverse(other.world_from_camera) @ world_from_camera
            share = overlap_of(grid, self._keyframes.view(other).pyramid.levels[0], other_from_view)
            if share >= self._settings.min_overlap:
                overlapping.append((-share, other.number))
        return [self._keyframes[number] for _, number in sorted(overlapping)]

    def measure_next(self, calibration: ColorCalibration) -> PoseEdge | None:
        """Measure the next pair; None if it came to nothing."""
        a, b = (self._keyframes[n] for n in self._waiting.popleft())
        view, known = self._keyframes.view(b), a.submap == b.submap
        if known:
            result = self.register(a, view, [inverse(a.world_from_camera) @ b.world_from_camera], calibration)
        else:
            result = self.recognise(a, view, [], calibration)
        if result is None or (known and not plausible(a, b, result.target_from_source, self._settings)):
            return None
        return PoseEdge(a.number, b.number, result.target_from_source, result.information)

    def register(
        self, keyframe: Keyframe, view: View, guesses: Sequence[Float64Array], calibration: ColorCalibration
    ) -> IcpResult | None:
        """Register a view to a keyframe near which it is known to be; None where it may be elsewhere as well.

        Args:
            keyframe: what it is registered to.
            view: the view.
            guesses: keyframe_from_view (4, 4) to start from.
            calibration: the colour camera as known so far.
        """
        return self._verified(keyframe, view, guesses, calibration, wide=False)

    def recognise(
        self, keyframe: Keyframe, view: View, guesses: Sequence[Float64Array], calibration: ColorCalibration
    ) -> IcpResult | None:
        """Register a view to a keyframe that appearance or a hypothesis led to: some of its features must agree, too.

        Args:
            keyframe: what it is registered to.
            view: the view.
            guesses: keyframe_from_view (4, 4) to start from, if any.
            calibration: the colour camera as known so far.
        """
        return self._verified(keyframe, view, guesses, calibration, wide=True)

    def _verified(
        self, keyframe: Keyframe, view: View, guesses: Sequence[Float64Array], calibration: ColorCalibration, wide: bool
    ) -> IcpResult | None:
        result = self._registration.register(self._keyframes.view(keyframe), view, guesses, calibration, wide)
        if result is None or not is_trusted(result, self._settings.min_overlap, ENOUGH_FEATURES):
            return None
        if wide and result.n_features < MIN_FEATURES:
            return None
        motion = result.target_from_source
        if contradiction(keyframe.view, view, motion, self._free_space) > self._settings.max_contradiction:
            return None
        alike = color_correlation(keyframe.view, view, motion, self._free_space)
        return result if alike >= self._settings.min_color_correlation else None


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
