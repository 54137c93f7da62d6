"""Picture matching: which pictures are registered to which, and what comes of it. The colour camera is learnt first, of
pairs that look most alike, so that all others are measured with the same one."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterable, Sequence
from dataclasses import replace
from functools import lru_cache
from itertools import combinations, pairwise

import numpy as np

from razer.arrays import Float32Array, Float64Array
from slam.backend.place_recognition import PlaceRecognition
from slam.backend.submaps.merge_hypotheses import same_motions
from slam.backend.verified_registration import VerifiedRegistration
from slam.backend.view_checks.color_check import ColorDifference, color_difference, other_colors
from slam.backend.view_overlap import separation
from slam.config import SlamConfig
from slam.frontend.color_calibration import ColorCalibration
from slam.frontend.features import depth_along
from slam.frontend.icp import IcpResult
from slam.frontend.keyframes import Keyframes, View
from slam.frontend.rigid_matches import RigidMatches, RigidMotion
from slam.frontend.wide_features import WideFeatures, root_sift
from slam.pose_edge import PoseEdge
from slam.report import TrackingQuality
from slam.sparse.camera_motion import turning_rad_s
from slam.sparse.measured_pair import MeasuredPair, Numbers

ALL_PAIRS_UP_TO = 150  # pictures in no order; of more each is compared with those that look most alike
# Of these. Fewer find what pictures share as well, but not what would have to be shared if a look-alike were true: of
# twelve corridors in no order one came out wrong with 30 that did not with all.
SHORTLIST = 40
# In the order of taking the camera's way says that, too, and shuffled pictures that pass for it all show one place; few
# find the loops then: of 17 walks past look-alikes, and of a kitchen, as much is located as with all.
SHORTLIST_IN_ORDER = 12
IN_ORDER = 0.5  # share of pictures that show what the one before does, from which they are in the order of taking
MOST_PROBES, MAY_BE_IN_ORDER = 12, 0.25  # such pairs that are tried, and the share of them from which all are
# From here on a picture is taken to be smeared as it turned. To take that of slower cameras into account makes nothing
# more exact, and poses of a kitchen surer of themselves than they are (mean NEES 430 for 240).
TURNS_FAST_RAD_S = 0.6
LEARNT_FROM = 60  # pairs at least, where there are as many; the colour camera is known to a pixel by then
ENOUGH_WAYS = 8  # round by a third picture that say what a pair would; where places repeat, three do for wrong ones too
ROUGH = 1 / 16  # of what features by themselves would tell of a motion: they err together
SURE_FEATURES = 40  # that agree, for a pair to teach anything of the colour camera
MOVED_PIXELS = 0.5  # of the reduced depth image, beyond which a feature's depth is read anew


class PictureMatching:
    """Pictures in the order of their stamps, and the pairs of them that were measured. `quality`: that of each
    picture's best pair; `unrecognised`: the pairs that were compared in vain;
    `sure_colors`: how far apart pictures that look most alike lie by their registrations, and what share of colours
    differs there."""

    def __init__(self, views: Iterable[View], config: SlamConfig) -> None:
        self._config = config
        self.keyframes, self.places = Keyframes(), PlaceRecognition()
        self.calibration = ColorCalibration.nominal()
        self._measured: dict[Numbers, MeasuredPair] = {}
        self.quality: dict[int, TrackingQuality] = {}
        self.sure_colors: list[tuple[float, float]] = []
        self.unrecognised: set[Numbers] = set()
        self.registration = VerifiedRegistration(self.keyframes, config, wide_alone=True)
        self._tried: set[Numbers] = set()
        self._closely: set[Numbers] = set()  # those that all features are compared of
        self._learnt: dict[Numbers, Float64Array] = {}  # how those lie that the colour camera was learnt from
        self._ties: defaultdict[int, dict[int, MeasuredPair]] = defaultdict(dict)  # by one picture and the other
        for view in sorted(views, key=lambda view: (view.stamp, view.index)):
            self.keyframes.add(view, np.eye(4), 0, 0.0)
            self.places.add(view)
        self._consecutive = set(pairwise(range(len(self.keyframes))))
        self._roots = lru_cache(maxsize=ALL_PAIRS_UP_TO)(self._root_sift)

    @property
    def pairs(self) -> list[MeasuredPair]:
        """All that were measured. Where the camera was carried from one to the next, that says more than any look:
        places repeat."""
        pairs = list(self._measured.values())
        if not self._are_in_order:
            return pairs
        return [replace(pair, is_next=pair.ends in self._consecutive) for pair in pairs]

    @property
    def _are_in_order(self) -> bool:
        """Whether most pictures show what the one before does."""
        return len(self._consecutive & self._measured.keys()) >= IN_ORDER * len(self._consecutive)

    def learn_camera(self) -> None:
        """Learn the colour camera, and read the depths of features where it saw them."""
        numbers = range(len(self.keyframes))
        best = [(n, *self._lookalikes(n, [other for other in numbers if other != n], 1)) for n in numbers]
        pairs = list(dict.fromkeys((min(pair), max(pair)) for pair in best if len(pair) > 1))
        for a, b in pairs[:: max(1, len(pairs) // LEARNT_FROM)]:
            result = self._registered(a, b) if self._rigid_motion(a, b) else None
            if result is not None and result.n_features >= SURE_FEATURES:
                self.calibration = result.calibration
                self._learnt[a, b] = result.target_from_source
        self.keyframes.recolor(self.calibration)
        for keyframe in self.keyframes.all:
            keyframe.view = _deep(keyframe.view, self.calibration)
        self.sure_colors = [self._colors(*pair, motion) for pair, motion in self._learnt.items()]

    def candidates(self) -> list[Numbers]:
        """The pairs that are worth measuring: those that follow each other and those that look alike, and of few
        pictures without order all."""
        numbers, are_in_order = range(len(self.keyframes)), self._are_in_order
        if len(numbers) <= ALL_PAIRS_UP_TO and not are_in_order:
            return list(combinations(numbers, 2))
        shortlist = SHORTLIST_IN_ORDER if are_in_order else SHORTLIST
        return sorted(self._consecutive | self.lookalikes(numbers, numbers, shortlist))

    def lookalikes(self, numbers: Iterable[int], among: Iterable[int], shortlist: int) -> set[Numbers]:
        """Pairs of pictures with those among others that look most like them."""
        others = list(among)
        return {
            (min(n, other), max(n, other))
            for n in numbers
            for other in self._lookalikes(n, [o for o in others if o != n], shortlist)
        }

    def _lookalikes(self, number: int, among: Sequence[int], shortlist: int) -> list[int]:
        return self.places.lookalikes(self.keyframes[number].view, among, 0.0, shortlist)

    def measure_consecutive(self) -> None:
        """Register pictures to those before, if some of them show the same: they may be in the order of taking, and
        where nothing has texture only that says so. What comes to nothing is compared by all features, as the way from
        one to the next tells look-alikes apart. Those of a camera that turned fast are registered anew."""
        pairs = sorted(self._consecutive)
        probes = pairs[:: -(-len(pairs) // MOST_PROBES) or 1]
        n_found = sum(self._measure(*pair, [np.eye(4)]) is not None for pair in probes)
        if n_found < MAY_BE_IN_ORDER * len(probes):
            return
        for pair in self._untried(pairs):
            self._measure(*pair, [np.eye(4)])
        self.measure_closely(pairs)
        self._remeasure_turned([self._measured[pair] for pair in pairs if pair in self._measured])

    def _remeasure_turned(self, consecutive: Sequence[MeasuredPair]) -> None:
        """Let pictures be taken as the camera turned, where it turned fast, and register their pairs anew."""
        edges = [pair.edge for pair in consecutive if pair.is_registered]
        turning = turning_rad_s(self.keyframes, edges)
        turned = {number for number, each in turning.items() if np.linalg.norm(each) > TURNS_FAST_RAD_S}
        for number in turned:
            self.keyframes[number].view = self.keyframes[number].view.turning(turning[number])
        for edge in edges:
            if turned & {edge.a, edge.b}:
                self._measure(edge.a, edge.b, [edge.a_from_b])

    def measure(self, pairs: Iterable[Numbers]) -> None:
        """Compare those pairs a < b that were not tried before, and keep the ones that share features, as these have
        them: those that share most first, and none that others tell already."""
        untried = self._untried(pairs)
        self._tried.update(untried)
        self._compare(untried)

    def measure_closely(self, pairs: Iterable[Numbers]) -> None:
        """Compare pairs once more, by all of their features, that were compared in vain or not at all."""
        vain = [pair for pair in pairs if pair in self.unrecognised or pair not in self._tried]
        self._tried.update(vain)
        self._closely.update(vain)
        self.unrecognised.difference_update(vain)
        self._compare(vain)

    def _compare(self, pairs: Sequence[Numbers]) -> None:
        rigid = {pair: self._rigid_motion(*pair) for pair in pairs}
        found = [(pair, motion) for pair, motion in rigid.items() if motion is not None]
        self.unrecognised.update(pair for pair, motion in rigid.items() if motion is None)
        for (a, b), motion in sorted(found, key=lambda one: -one[1].n_explained):
            if self._n_ways(a, b, motion.target_from_source) < ENOUGH_WAYS:
                self._add(self._candidate(a, b, motion))

    def _untried(self, pairs: Iterable[Numbers]) -> list[Numbers]:
        return [pair for pair in pairs if pair not in self._tried]

    def _rigid_motion(self, a: int, b: int) -> RigidMotion | None:
        return self.registration.rigid_motion(self.keyframes[a], self.keyframes[b].view, self._matches(a, b))

    def _matches(self, a: int, b: int) -> RigidMatches:
        """Prominent features alone say what is compared in vain, by which look-alikes are told."""
        target, source = (self.keyframes[n].view.wide for n in (a, b))
        roots = self._roots(a), self._roots(b)
        if (a, b) in self._closely:
            return RigidMatches(target.features, source.features, roots)
        return RigidMatches(
            target.prominent, source.prominent, (roots[0][: target.n_prominent], roots[1][: source.n_prominent])
        )

    def _root_sift(self, number: int) -> Float32Array:
        return root_sift(self.keyframes[number].view.wide.features.descriptors)

    def _n_ways(self, a: int, b: int, a_from_b: Float64Array) -> int:
        """By how many third pictures that share features with both a motion (4, 4) is said already."""
        ways = [self._ties[a][c].motion(a) @ self._ties[c][b].motion(c) for c in self._ties[a].keys() & self._ties[b]]
        return int(same_motions(np.stack([a_from_b, *ways]), np.zeros(3))[0, 1:].sum())

    def _candidate(self, a: int, b: int, motion: RigidMotion) -> MeasuredPair:
        """A pair as its features have it, roughly."""
        edge = PoseEdge(a, b, motion.target_from_source, ROUGH * motion.information)
        return self._pair(edge, motion.n_explained)

    def _pair(self, edge: PoseEdge, n_features: int) -> MeasuredPair:
        """A pair that is not registered, of two pictures that lie as an edge has them."""
        views = self.keyframes[edge.a].view, self.keyframes[edge.b].view
        told = color_difference(*views, edge.a_from_b, self._config.free_space) or ColorDifference(0.0, 0)
        score = told.n_readings / max(1, min(int(np.count_nonzero(view.sparse.depth)) for view in views))
        apart = separation(*views, edge.a_from_b)
        return MeasuredPair(edge, n_features, float(score), told.share, apart, is_registered=False)

    def _colors(self, a: int, b: int, a_from_b: Float64Array) -> tuple[float, float]:
        """How far apart two pictures lie, and what share of their colours differs there."""
        views = self.keyframes[a].view, self.keyframes[b].view
        return separation(*views, a_from_b), other_colors(*views, a_from_b, self._config.free_space) or 0.0

    def _add(self, pair: MeasuredPair) -> None:
        a, b = pair.ends
        self._measured[a, b] = self._ties[a][b] = self._ties[b][a] = pair

    def register(self, pair: MeasuredPair) -> MeasuredPair | None:
        """A pair as its registration has it, with the colours that it had before; None where that came to nothing."""
        return self._measure(*pair.ends, rough=pair)

    def _measure(
        self, a: int, b: int, guesses: Sequence[Float64Array] = (), rough: MeasuredPair | None = None
    ) -> MeasuredPair | None:
        """Register two pictures; `rough`: the pair as it was before."""
        self._tried.add((a, b))
        result = self._registered(a, b, guesses)
        if result is None:
            self._forget(a, b)
            return None
        edge = PoseEdge(a, b, result.target_from_source, result.information)
        before = rough or self._pair(edge, result.n_features)
        pair = replace(before, edge=edge, n_features=result.n_features, score=result.score, is_registered=True)
        self._add(pair)
        quality = TrackingQuality.of(result)
        for n in (a, b):
            if n not in self.quality or self.quality[n].n_features < quality.n_features:
                self.quality[n] = quality
        return pair

    def _forget(self, a: int, b: int) -> None:
        """Let a pair be one that was compared in vain."""
        self.unrecognised.add((a, b))
        if self._measured.pop((a, b), None):
            del self._ties[a][b], self._ties[b][a]

    def _registered(self, a: int, b: int, guesses: Sequence[Float64Array] = ()) -> IcpResult | None:
        """Guesses say where to start if features do not, nor a registration that the camera was learnt from."""
        target, view = self.keyframes[a], self.keyframes.view(self.keyframes[b])
        if (a, b) in self._learnt:
            return self.registration.register(target, view, [self._learnt[a, b]], self.calibration)
        matches = self._matches(a, b)
        return self.registration.recognise(target, view, () if matches.is_sure else guesses, self.calibration, matches)


def _deep(view: View, calibration: ColorCalibration) -> View:
    """A view whose features have the depths of where a colour camera saw them."""
    features, k = view.wide.features, view.pyramid.intrinsics
    rays = features.rays.astype(np.float64)
    far = np.where(features.depth_m > 0, features.depth_m, 2.0)
    moved = (calibration.depth_rays(rays, far) - rays) * (k.fx, k.fy)
    depth = depth_along(view.pyramid.depth, k, calibration, rays)
    depth = np.where(np.abs(moved).max(axis=1) > MOVED_PIXELS, depth, features.depth_m)
    deep = replace(features, depth_m=depth.astype(np.float32))
    return replace(view, wide=WideFeatures.known(deep, view.wide.n_prominent))
