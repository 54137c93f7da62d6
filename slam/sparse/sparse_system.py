"""Global matching of few pictures far apart, in any order: structure from motion with depth. All are registered to all
that look alike, a consistent set of these is grown from the surest, and a pose graph is solved over it."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from itertools import combinations

import numpy as np

from razer.arrays import Float64Array, Pose
from razer.frame import Frame
from razer.geometry import inverse
from slam.backend.loop_closure import LoopClosure
from slam.backend.outlier_edges import is_outlier
from slam.backend.pose_graph import PoseGraph
from slam.config import SlamConfig
from slam.frontend.color_calibration import ColorCalibration
from slam.frontend.features import no_features
from slam.frontend.keyframes import STILL, Keyframe, Keyframes, View
from slam.pose_edge import PoseEdge
from slam.report import GraphReport, PoseReport, TrackingQuality
from slam.se3 import orthonormal
from slam.sparse.known_pairs import KnownPairs
from slam.sparse.measured_pair import Numbers
from slam.sparse.pair_graph import components
from slam.sparse.picture_matching import ALL_PAIRS_UP_TO, PictureMatching
from slam.sparse.placement.parts import Parts
from slam.uncertainty.pose_uncertainty import CovarianceScale, final_uncertainty

LATE_SHORTLIST = 8  # pictures of the largest part that those outside it are compared with once more
ROUNDS = 2  # of measuring neighbours at the poses that follow
NO_DESCRIPTORS = np.zeros((0, 32), np.uint8)  # ORB's: wide features match as well and from farther apart
NOWHERE = PoseReport(None, None, None)


def picture_view(frame: Frame, config: SlamConfig) -> View:
    """A picture as it is matched: by wide features alone, extracted now, as the frame would be kept until they are."""
    view = View.of(frame, no_features(NO_DESCRIPTORS), STILL, config, ColorCalibration.nominal())
    view.wide.extract()
    return view


class SparseSystem:
    """Poses of pictures, all at once when the last one came: a source of poses that corrects them all in the end."""

    def __init__(self, config: SlamConfig = SlamConfig()) -> None:  # noqa: B008
        self.config = config
        self.keyframes, self.graph = Keyframes(), PoseGraph()
        self.calibration = ColorCalibration.nominal()
        self.n_pairs = 0  # that were registered
        self.quality: Mapping[int, TrackingQuality] = {}  # by frame, of its best pair
        self._origin = 0
        self._views: list[View] = []
        self._news: dict[int, Pose] = {}
        self._report = NOWHERE

    @property
    def n_loops(self) -> int:
        """Edges beyond those that it takes to tie all pictures together."""
        n_tied = int((self.keyframes.submaps() == 0).sum())
        return max(0, len(self.graph.edges) - max(0, n_tied - 1))

    def locate(self, frame: Frame) -> None:
        """Take in a picture; where it was taken is known in the end."""
        self._views.append(picture_view(frame, self.config))

    def corrections(self) -> Mapping[int, Pose | None]:
        """All poses once they are known."""
        news, self._news = self._news, {}
        return dict[int, Pose | None](news)

    def finish(self) -> None:
        """Match all pictures, and solve for their poses. The largest part is the world, whose origin is its first
        picture; of others no pose is known."""
        matching = PictureMatching(self._views, self.config)
        self._views, self.keyframes = [], matching.keyframes
        if not len(self.keyframes):
            return
        matching.learn_camera()
        self.calibration = matching.calibration
        matching.measure_consecutive()
        matching.measure(matching.candidates())
        parts = self._grown(matching)
        self.n_pairs = sum(pair.is_registered for pair in matching.pairs)
        self.quality = {self.keyframes[n].view.index: quality for n, quality in matching.quality.items()}
        self._lay_out(parts)
        self._solve(matching)
        self._news = self.trajectory()
        uncertainty = final_uncertainty(self.graph, CovarianceScale().measure(self.graph))
        graph = GraphReport.of(self.keyframes, self.graph, self.n_loops, uncertainty)
        self._report = PoseReport(None, None, graph)

    def _grown(self, matching: PictureMatching) -> Parts:
        """Parts of all pairs; what lies in different ones at first is compared once more."""
        parts = Parts(self.keyframes, self._known(matching), self.config)
        parts.grow()
        n_pairs = len(matching.pairs)
        matching.measure_closely(self._apart(matching, parts))
        if len(matching.pairs) > n_pairs:
            parts.learn(self._known(matching))
        parts.settle()
        return parts

    def _known(self, matching: PictureMatching) -> KnownPairs:
        of_all = matching.pairs, self.config, matching.unrecognised, matching.sure_colors
        return KnownPairs(self.keyframes, *of_all, register=matching.register)

    def _apart(self, matching: PictureMatching, parts: Parts) -> list[Numbers]:
        """The pairs of pictures of different parts; of many pictures, what lies outside the largest part with what
        looks most like it within."""
        part_of, world = parts.part_of, max(parts.members.values(), key=len)
        if len(part_of) <= ALL_PAIRS_UP_TO:
            return [(a, b) for a, b in combinations(range(len(part_of)), 2) if part_of[a] != part_of[b]]
        outside = set(range(len(part_of))) - set(world)
        return sorted(matching.lookalikes(outside, world, LATE_SHORTLIST))

    def _lay_out(self, parts: Parts) -> None:
        """Keyframes and pose graph of the largest part; where others lie to it nobody knows."""
        world = min(parts.members.values(), key=lambda members: (-len(members), min(members)))
        self._origin = origin = min(world, key=lambda n: self.keyframes[n].view.index)
        origin_from_part = inverse(parts.poses[origin])
        for keyframe in self.keyframes.all:
            _leave_outside(keyframe)
        for number in world:
            self.keyframes[number].submap = 0
            self.keyframes[number].world_from_camera = orthonormal(origin_from_part @ parts.poses[number])
        agreeing = parts.agreeing(parts.part_of[origin])
        self._start_graph([pair.edge for pair in agreeing if pair.is_registered])

    def _start_graph(self, edges: Sequence[PoseEdge]) -> None:
        """The pose graph of the pictures of the world, the origin first."""
        self.graph = PoseGraph(fixed=self._origin)
        world = [keyframe for keyframe in self.keyframes.all if keyframe.submap == 0]
        for keyframe in sorted(world, key=lambda k: k.number != self._origin):
            self.graph.add_keyframe(keyframe.number, keyframe.world_from_camera)
        for edge in edges:
            self.graph.add_edge(edge)

    def _solve(self, matching: PictureMatching) -> None:
        """Smooth over everything, with neighbours measured at the poses that follow, and without what proved false."""
        loops = LoopClosure(self.keyframes, self.graph, matching.places, matching.registration, self.config)
        self._set_poses(self.graph.smooth())
        for _ in range(ROUNDS):
            loops.queue_neighbors()
            while len(loops):
                edge = loops.measure_next(self.calibration)
                if edge is not None and loops.is_plausible(edge):
                    self.graph.add_edge(edge)
            self._set_poses(self.graph.smooth())
        self._drop_outliers()

    def _drop_outliers(self) -> None:
        """Without edges that the others contradict; pictures that none joins to the world any more are outside of it,
        and of its graph, which could not be solved for them."""
        poses, edges = self.graph.poses, self.graph.edges
        consistent = [edge for edge in edges if not is_outlier(edge, poses)]
        if len(consistent) == len(edges):
            return
        part = components(len(self.keyframes), consistent)
        for keyframe in self.keyframes.all:
            if part[keyframe.number] != part[self._origin]:
                _leave_outside(keyframe)
        self._start_graph([edge for edge in consistent if self.keyframes[edge.a].submap == 0])
        self._set_poses(self.graph.smooth())

    def _set_poses(self, poses: Mapping[int, Float64Array]) -> None:
        for number, pose in poses.items():
            self.keyframes[number].world_from_camera = pose

    def trajectory(self) -> dict[int, Pose]:
        """world_from_camera of every picture of the world, as known now."""
        located = sorted((k.view.index, k) for k in self.keyframes.all if k.submap == 0)
        return {index: orthonormal(keyframe.world_from_camera) for index, keyframe in located}

    def report(self) -> PoseReport:
        """Nothing until the end; then, once, the pose graph with the covariances of all."""
        report, self._report = self._report, NOWHERE
        return report


def _leave_outside(keyframe: Keyframe) -> None:
    """Let a picture be none of the world, in a submap of its own, as nobody knows where it lies to any other."""
    keyframe.submap = 1 + keyframe.number
