"""Keyframe map: submaps of keyframes that grow, close loops, are merged, and are smoothed together."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from razer.arrays import Float64Array
from razer.geometry import inverse
from slam.backend.doubtful_odometry import doubtful_odometry
from slam.backend.dynamic_masking import DynamicMasking
from slam.backend.loop_closure import RECENT, LoopClosure
from slam.backend.outlier_edges import is_outlier
from slam.backend.place_recognition import PlaceRecognition
from slam.backend.pose_graph import PoseGraph
from slam.backend.submaps.local_map import LocalMap
from slam.backend.submaps.merge_hypotheses import MergeHypotheses
from slam.backend.submaps.placement_check import PlacementCheck
from slam.backend.submaps.submap_merging import Outcome, SubmapMerging
from slam.backend.submaps.submap_search import Candidate, SubmapSearch
from slam.backend.verified_registration import VerifiedRegistration
from slam.backend.view_overlap import near_poses
from slam.config import SlamConfig
from slam.frontend.color_calibration import ColorCalibration
from slam.frontend.icp import IcpResult
from slam.frontend.keyframes import Keyframe, Keyframes, LocatedView, View
from slam.pose_edge import PoseEdge, PosePrior
from slam.se3 import orthonormal

FINAL_SHORTLIST = 8  # places that a keyframe still unanchored at the end is compared with; the camera waits no more
LOCAL_MAP = 2  # keyframes besides the last that a camera that was just lost is looked for in front of
FINAL_ROUNDS = 2  # of closing loops and finding new neighbours at the poses that follow; a third finds none


class KeyframeMap:
    """Keyframes in submaps: submap 0, which begins with the first keyframe, is the world; others are unanchored until
    they are merged with it. `version` grows with each change of the keyframes' poses."""

    def __init__(self, config: SlamConfig, graph: PoseGraph | None = None) -> None:
        self.keyframes = Keyframes()
        self.graph = PoseGraph() if graph is None else graph
        self.version = 0
        self._config = config
        self._registration = VerifiedRegistration(self.keyframes, config)
        self._places = PlaceRecognition()
        self._loops = LoopClosure(self.keyframes, self.graph, self._places, self._registration, config)
        hypotheses = MergeHypotheses(self.keyframes, config.submaps)
        local_map = LocalMap(self.keyframes, self._registration, config)
        self._search = SubmapSearch(self.keyframes, self._places, hypotheses, self._registration, local_map, config)
        placement = PlacementCheck(self.keyframes, self.graph, config)
        self._merging = SubmapMerging(self.keyframes, self.graph, hypotheses, placement)
        self._masking = DynamicMasking(self.keyframes, config)
        self._n_submaps = self._chain = 0

    def pose(self, keyframe: int, keyframe_from_camera: Float64Array) -> Float64Array:
        """world_from_camera of a camera in front of a keyframe."""
        return orthonormal(self.keyframes[keyframe].world_from_camera @ keyframe_from_camera)

    def begin_submap(self, view: View, travelled_m: float) -> Keyframe:
        """A first keyframe that no edge connects with those before."""
        pose = self.keyframes.all[-1].world_from_camera if self._n_submaps else np.eye(4)
        self._chain += self._n_submaps > 0
        keyframe = self.keyframes.add(view, pose, self._n_submaps, travelled_m, self._chain)
        self.graph.add_keyframe(keyframe.number, pose, unanchored=self._n_submaps > 0)
        self._n_submaps += 1
        self._loops.add(keyframe)
        self._optimise()
        return keyframe

    def extend(self, before: Keyframe, view: View, result: IcpResult, travelled_m: float) -> Keyframe:
        """A further keyframe, which tracking registered to the one before, without what moved in it.

        Args:
            before: the keyframe it was registered to.
            view: the view that becomes a keyframe.
            result: before_from_view with its information.
            travelled_m: how far the camera has travelled, metres.
        """
        pose = self.pose(before.number, result.target_from_source)
        static = self._masking.static_part(view, before, pose, travelled_m)
        return self._add_before(before, static, result, travelled_m, before.chain, is_odometry=True)

    def resume(self, before: Keyframe, view: View, result: IcpResult, travelled_m: float) -> Keyframe:
        """A further keyframe, with which tracking goes on where the camera was found after it was lost: if that proves
        wrong, what follows can be moved.

        Args:
            before: the keyframe in front of which it was found.
            view: the view that becomes a keyframe.
            result: before_from_view with its information.
            travelled_m: how far the camera has travelled, metres.
        """
        self._chain += 1
        return self._add_before(before, view, result, travelled_m, self._chain, is_odometry=False)

    def _add_before(
        self, before: Keyframe, view: View, result: IcpResult, travelled_m: float, chain: int, is_odometry: bool
    ) -> Keyframe:
        self.keyframes.recolor(result.calibration)
        pose, number = self.pose(before.number, result.target_from_source), len(self.keyframes)
        edge = PoseEdge(before.number, number, result.target_from_source, result.information, is_odometry)
        keyframe = self.keyframes.add(view, pose, before.submap, travelled_m, chain)
        return self._added(keyframe, [edge], [], unanchored=not is_odometry)

    def place(
        self,
        view: View,
        world_from_camera: Float64Array,
        travelled_m: float,
        edges: Sequence[PoseEdge],
        priors: Sequence[PosePrior],
    ) -> Keyframe:
        """A further keyframe of the world, of which poses from elsewhere know something.

        Args:
            view: the view that becomes a keyframe.
            world_from_camera: (4, 4) its first guess.
            travelled_m: how far the camera has travelled, metres.
            edges: what was measured of it.
            priors: what the poses from elsewhere say of it.
        """
        return self._added(self.keyframes.add(view, world_from_camera, 0, travelled_m), edges, priors)

    def _added(
        self, keyframe: Keyframe, edges: Sequence[PoseEdge], priors: Sequence[PosePrior], unanchored: bool = False
    ) -> Keyframe:
        """A new keyframe, once the graph has it and it was held against what others saw."""
        self.graph.add_keyframe(keyframe.number, keyframe.world_from_camera, unanchored)
        for edge in edges:
            self.graph.add_edge(edge)
        for prior in priors:
            self.graph.add_prior(prior)
        self._loops.add(keyframe)
        self._optimise()
        self._review(keyframe)
        return keyframe

    def smooth(self, priors: Sequence[PosePrior]) -> None:
        """Smooth over everything once more, under other priors."""
        self.graph.replace(self.graph.edges, priors)
        self._set_poses(self.graph.smooth())

    def recognise(
        self, keyframe: Keyframe, view: View, guess: Float64Array, calibration: ColorCalibration
    ) -> IcpResult | None:
        """Register a view to a keyframe that tracking does not lead to; None where it may be elsewhere as well.

        Args:
            keyframe: what it is registered to.
            view: the view.
            guess: keyframe_from_view (4, 4) to start from, besides what features say.
            calibration: the colour camera as known so far.
        """
        return self._registration.recognise(keyframe, view, [guess], calibration)

    def around(self, keyframe: Keyframe, keyframe_from_camera: Float64Array, view: View) -> list[Keyframe]:
        """A keyframe, and those round about a camera in front of it that look like a view.

        Args:
            keyframe: the keyframe that comes first.
            keyframe_from_camera: (4, 4) about where the camera is.
            view: what it sees.
        """
        world_from_camera = keyframe.world_from_camera @ keyframe_from_camera
        numbers = self.keyframes.of_submap(keyframe.submap)
        numbers = numbers[numbers != keyframe.number]
        poses = self.keyframes.poses()[numbers]
        near = numbers[near_poses(world_from_camera, poses, self._config.loop_closure)]
        return [keyframe, *(self.keyframes[n] for n in self._places.lookalikes(view, near, 0.0, LOCAL_MAP))]

    def tie(self, a: Keyframe, b: Keyframe, a_from_b: Float64Array) -> bool:
        """Have two keyframes measured against each other that tracking has at a_from_b (4, 4), if that fits to where
        they are, and say whether it does."""
        if a.number > b.number:
            return self.tie(b, a, inverse(a_from_b))
        fits = self._loops.is_plausible(PoseEdge(a.number, b.number, a_from_b, np.eye(6)))
        if fits:
            self._loops.queue_pair(a.number, b.number)
        return fits

    def search_submaps(self, located: LocatedView, calibration: ColorCalibration) -> None:
        """Compare a view of an unanchored submap with places of other submaps."""
        self._compare(located, calibration, self._search.next_candidates(located))

    def _compare(self, located: LocatedView, calibration: ColorCalibration, candidates: Sequence[Candidate]) -> bool:
        """Whether a view of one submap, compared with keyframes of others, with the hypotheses before merges it."""
        recognised = self._search.recognised(located, candidates, calibration)
        return any(self._add_hypothesis(edge, located.view.index, strength) for edge, strength in recognised)

    def _search_unanchored(self, calibration: ColorCalibration) -> None:
        """Compare the keyframes still unanchored with all places that have any similarity."""
        for keyframe in self.keyframes.all:
            if keyframe.submap:
                located = LocatedView(self.keyframes.view(keyframe), keyframe, np.eye(4))
                self._compare(located, calibration, self._search.candidates(located, FINAL_SHORTLIST))

    def close_loops(self, calibration: ColorCalibration, n_pairs: int | None = None) -> None:
        """Measure so many of the pairs of keyframes that wait, None = all."""
        waiting = len(self._loops)
        for _ in range(waiting if n_pairs is None else min(n_pairs, waiting)):
            edge = self._loops.measure_next(calibration)
            if edge is None:
                continue
            if self._loops.is_plausible(edge):
                self.graph.add_edge(edge)
            elif self._are_of_two_chains(edge) or self._loops.may_have_drifted(edge):
                self._add_hypothesis(edge, self.keyframes[edge.b].view.index, 1.0)

    def _are_of_two_chains(self, edge: PoseEdge) -> bool:
        return self.keyframes[edge.a].chain != self.keyframes[edge.b].chain

    def _add_hypothesis(self, edge: PoseEdge, frame: int, strength: float) -> bool:
        """Take in that a view fits where its chain does not have it; whether that moved anything."""
        outcome = self._merging.add(edge, frame, strength)
        if outcome is Outcome.MOVED:
            self._optimise()
        return outcome is Outcome.MOVED

    def _review(self, keyframe: Keyframe) -> None:
        """Part the chain of a keyframe, if it was placed by what it looks like, from what it contradicts."""
        if keyframe.chain and self._merging.review(keyframe.chain, self._n_submaps):
            self._n_submaps += 1
            self._optimise()

    def _optimise(self) -> None:
        self._set_poses(self.graph.optimise())

    def _set_poses(self, poses: Mapping[int, Float64Array]) -> None:
        self.version += 1
        for number, pose in poses.items():
            self.keyframes[number].world_from_camera = pose

    def finish(self, calibration: ColorCalibration) -> None:
        """Merge what can be merged, measure the pairs that overlap and add something, smooth over everything, and drop
        loop closures that proved false."""
        self._search_unanchored(calibration)
        for _ in range(FINAL_ROUNDS):
            self.close_loops(calibration)
            self._optimise()
            self._loops.queue_neighbors()
        self.close_loops(calibration)
        self._optimise()
        self._remeasure_odometry(calibration)
        self._set_poses(self._smooth_without_outliers())

    def _remeasure_odometry(self, calibration: ColorCalibration) -> None:
        """Register anew what tracking measured and loops contradict, from where these have it."""
        anew = {id(edge): self._remeasured(edge, calibration) for edge in doubtful_odometry(self.graph)}
        if anew:
            self.graph.replace([anew.get(id(edge), edge) for edge in self.graph.edges])
            self._optimise()

    def _remeasured(self, edge: PoseEdge, calibration: ColorCalibration) -> PoseEdge:
        """An odometry edge as the graph leads to it, unless depth fits better where it was."""
        a, b = self.keyframes[edge.a], self.keyframes[edge.b]
        guesses = [inverse(a.world_from_camera) @ b.world_from_camera, edge.a_from_b]
        result = self._registration.register(a, self.keyframes.view(b), guesses, calibration)
        if result is None:
            return edge
        return PoseEdge(edge.a, edge.b, result.target_from_source, result.information, is_odometry=True)

    def _smooth_without_outliers(self) -> Mapping[int, Float64Array]:
        """The smoothed poses, once more where they contradict loop closures, without these."""
        poses, edges = self.graph.smooth(), self.graph.edges
        consistent = [edge for edge in edges if edge.is_odometry or not is_outlier(edge, poses)]
        if len(consistent) == len(edges):
            return poses
        self.graph.replace(consistent)
        return self.graph.smooth()

    def make_world(self, submap: int) -> None:
        """Let an unanchored submap be the world, and the world unanchored."""
        for keyframe in self.keyframes.all:
            keyframe.submap = {0: submap, submap: 0}.get(keyframe.submap, keyframe.submap)
        self.graph.fix(next(keyframe.number for keyframe in self.keyframes.all if keyframe.submap == 0))
        self._optimise()

    @property
    def n_loops(self) -> int:
        """Edges that close a loop: between keyframes that tracking does not connect within a few steps."""
        ends, is_odometry = self.graph.edge_table()
        return int(((ends[:, 1] - ends[:, 0] > RECENT) & ~is_odometry).sum())
