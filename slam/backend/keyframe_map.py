"""The keyframes with all that was measured between them: submaps that grow, are tied together, and are smoothed."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np

from razer.arrays import Float64Array
from razer.geometry import inverse
from slam.backend.free_space_check import contradiction
from slam.backend.loop_closure import ALIKE_AT_ALL, RECENT, SHORTLIST, LoopClosure, in_reach
from slam.backend.pose_graph import PoseEdge, PoseGraph, mahalanobis
from slam.backend.submap_merging import MergeHypothesis, SubmapMerging
from slam.frontend.color_calibration import ColorCamera
from slam.frontend.icp import IcpResult
from slam.frontend.keyframes import Keyframe, Keyframes, View
from slam.frontend.view_registration import Grids
from slam.se3 import orthonormal

# So many frames are each compared with the other submaps, after a submap was begun and after each that fitted; else
# each third is.
ALERT, RELAXED = 20, 3
PATIENT_SHORTLIST = 8  # places that a keyframe still unanchored at the end is compared with
MAX_AGAINST_TIE = 0.05  # mean contradiction of all views in reach; look-alikes have 0.3 or more, true ties 0.003
MAX_SURPRISE = 15.0  # sigmas; an edge that the finished graph contradicts so much is false


@dataclass
class KeyframeMap:
    """Keyframes in submaps: submap 0, which begins with the first keyframe, is the world; others are unanchored until
    they are tied to it. `version` grows with each change of the keyframes' poses."""

    keyframes: Keyframes = field(default_factory=Keyframes)
    graph: PoseGraph = field(default_factory=PoseGraph)
    version: int = 0

    def __post_init__(self) -> None:
        self._closures = LoopClosure(self.keyframes)
        self._ties = SubmapMerging()
        self._n_pieces = 0
        self._alert = 0

    def pose(self, keyframe: int, keyframe_from_camera: Float64Array) -> Float64Array:
        """world_from_camera of a camera in front of a keyframe."""
        return orthonormal(self.keyframes[keyframe].world_from_camera @ keyframe_from_camera)

    def begin_submap(self, view: View, grids: Grids, travelled_m: float) -> Keyframe:
        """A first keyframe that nothing ties to those before."""
        pose = self.keyframes.all[-1].world_from_camera if self._n_pieces else np.eye(4)
        keyframe = self.keyframes.add(view, grids, pose, self._n_pieces, travelled_m)
        self.graph.add_keyframe(keyframe.number, pose, unanchored=self._n_pieces > 0)
        self._n_pieces += 1
        self._alert = ALERT
        self._closures.add(keyframe)
        self._optimise()
        return keyframe

    def extend(self, before: Keyframe, view: View, grids: Grids, found: IcpResult, travelled_m: float) -> Keyframe:
        """A further keyframe, found in front of the one before."""
        pose = self.pose(before.number, found.target_from_source)
        keyframe = self.keyframes.add(view, grids, pose, before.submap, travelled_m)
        self.graph.add_keyframe(keyframe.number, pose)
        self.graph.add_edge(
            PoseEdge(before.number, keyframe.number, found.target_from_source, found.information, sure=True)
        )
        self._closures.add(keyframe)
        self._optimise()
        return keyframe

    def seen_from(
        self, keyframe: Keyframe, view: View, grids: Grids, guess: Float64Array, camera: ColorCamera
    ) -> IcpResult | None:
        """A view in front of a keyframe, near a guess; None where it may be elsewhere as well."""
        return self._closures.seen_from(keyframe, view, grids, [guess], camera)

    def look_round(
        self, view: View, grids: Grids, here: Keyframe, here_from_camera: Float64Array, camera: ColorCamera
    ) -> None:
        """Compare a view in front of a keyframe of a submap unanchored with places of other submaps, now and then."""
        self._alert -= 1
        if self._alert < 0 and self._alert % RELAXED:
            return
        self._compare(view, grids, here, here_from_camera, camera)

    def _compare(
        self,
        view: View,
        grids: Grids,
        here: Keyframe,
        here_from_camera: Float64Array,
        camera: ColorCamera,
        shortlist: int = SHORTLIST,
    ) -> bool:
        """Whether a view of one submap, with what was seen before, ties it to another."""
        others = [k.number for k in self.keyframes.all if k.submap != here.submap]
        for number in self._closures.lookalikes(view.features, others, ALIKE_AT_ALL, shortlist):
            found = self._closures.seen_from(self.keyframes[number], view, grids, [], camera)
            if found is None:
                continue
            moved = found.target_from_source @ inverse(here_from_camera)
            if self._hear(PoseEdge(number, here.number, moved, found.information), view.index, found.score):
                return True
        return False

    def _tie_pieces(self, camera: ColorCamera) -> None:
        """Compare the keyframes still unanchored with all places that look at all alike."""
        for keyframe in self.keyframes.all:
            if keyframe.submap:
                grids = self.keyframes.grids(keyframe.number)
                self._compare(keyframe.view, grids, keyframe, np.eye(4), camera, PATIENT_SHORTLIST)

    def work(self, camera: ColorCamera, n_pairs: int | None = None) -> None:
        """Measure so many of the pairs of keyframes that wait, None = all."""
        waiting = len(self._closures)
        for _ in range(waiting if n_pairs is None else min(n_pairs, waiting)):
            edge = self._closures.measure_next(camera)
            if edge is None:
                continue
            if self.keyframes[edge.a].submap == self.keyframes[edge.b].submap:
                self.graph.add_edge(edge)
            else:
                self._hear(edge, self.keyframes[edge.b].view.index, 1.0)

    def _hear(self, edge: PoseEdge, frame: int, strength: float) -> bool:
        """Take in that a view of one submap was found in another; whether that ties the two together."""
        self._alert = ALERT
        a, b = self.keyframes[edge.a], self.keyframes[edge.b]
        shift = a.world_from_camera @ edge.a_from_b @ inverse(b.world_from_camera)
        home_from_submap = shift if a.submap < b.submap else inverse(shift)
        home, submap = sorted((a.submap, b.submap))
        agreeing = self._ties.add(home, submap, MergeHypothesis(frame, edge, home_from_submap, strength))
        if not agreeing or self._contradicted(home, submap, agreeing[0].home_from_submap):
            return False
        self._join(home, submap, agreeing[0].home_from_submap)
        for hypothesis in agreeing:
            self.graph.add_edge(hypothesis.edge)
        self._optimise()
        return True

    def _contradicted(self, home: int, submap: int, home_from_submap: Float64Array) -> bool:
        """Whether views of a submap, if it were there, stand where those of the other saw through. A look-alike is like
        the view it was taken for, and not like the views around that one."""
        there = [keyframe for keyframe in self.keyframes.all if keyframe.submap == home]
        against = []
        for here in self.keyframes.all:
            if here.submap == submap:
                moved = home_from_submap @ here.world_from_camera
                against += [
                    contradiction(other.view, here.view, inverse(other.world_from_camera) @ moved)
                    for other in in_reach(moved, there)
                ]
        return bool(against) and float(np.mean(against)) > MAX_AGAINST_TIE

    def _join(self, home: int, submap: int, home_from_submap: Float64Array) -> None:
        for keyframe in self.keyframes.all:
            if keyframe.submap == submap:
                keyframe.submap = home
                keyframe.world_from_camera = home_from_submap @ keyframe.world_from_camera
        self._ties.forget(submap)
        self.graph.shift({k.number: k.world_from_camera for k in self.keyframes.all})

    def _optimise(self) -> None:
        self._take(self.graph.optimise())

    def _take(self, poses: Mapping[int, Float64Array]) -> None:
        self.version += 1
        for number, pose in poses.items():
            self.keyframes[number].world_from_camera = pose

    def finish(self, camera: ColorCamera) -> None:
        """Tie what can be tied, measure all pairs that overlap, smooth over everything, and drop closures that proved
        false."""
        self._tie_pieces(camera)
        for _ in range(2):
            self.work(camera)
            self._optimise()
            self._closures.queue_neighbours()
        self.work(camera)
        self._optimise()
        poses = self.graph.smooth()
        good = [edge for edge in self.graph.edges if edge.sure or mahalanobis(edge, poses) <= MAX_SURPRISE]
        if len(good) < len(self.graph.edges):
            self.graph.replace(good)
            poses = self.graph.smooth()
        self._take(poses)

    def make_world(self, submap: int) -> None:
        """Let a submap that nothing ties to the world be the world, and the world unanchored."""
        for keyframe in self.keyframes.all:
            keyframe.submap = {0: submap, submap: 0}.get(keyframe.submap, keyframe.submap)
        self.graph.fix(next(keyframe.number for keyframe in self.keyframes.all if keyframe.submap == 0))
        self._optimise()

    @property
    def n_loops(self) -> int:
        """Edges that close a loop: between keyframes that tracking does not connect within a few steps."""
        return sum(edge.b - edge.a > RECENT for edge in self.graph.edges)
