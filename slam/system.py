"""Where the camera was: poses that came with the frames, or estimated ones, behind the same few methods."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Protocol

import numpy as np

from razer.frame import Frame
from razer.geometry import Array, inverse
from slam.alignment import Grids
from slam.closures import RECENT, Closures
from slam.color_camera import ColorCamera
from slam.features import FeatureFinder
from slam.keyframes import Keyframe, Keyframes, View
from slam.pose_graph import Edge, PoseGraph, surprise
from slam.registration import Registration
from slam.report import Finding, GraphReport, PoseReport
from slam.rigid_motion import angle_deg, length_m, orthonormal
from slam.ties import Ties, Witness
from slam.tracking import Tracking, needs_keyframe

Pose = Array

PATIENCE = 2  # frames that show something but nothing known, after which a new piece of the map is begun
RESUME = 30  # frames after which the camera may be anywhere
# So many frames are each compared with the other pieces, after a piece was begun and after each that fitted; else each
# fifth is.
ALERT, RELAXED = 20, 5
MIN_READINGS, MIN_CORNERS = 500, 50  # valid depth pixels and corners that a piece must begin with
MIN_FEATURES = 20  # that agree, to go on where tracking was lost
MOVED_M, MOVED_DEG = 0.002, 0.1  # a correction worth telling
PAIRS_PER_FRAME = 1
MAX_SURPRISE = 15.0  # sigmas; an edge that the finished graph contradicts so much is false


class Poses(Protocol):
    """A source of poses."""

    def locate(self, frame: Frame) -> Pose | None:
        """world_from_camera (4, 4) of a frame, None = lost; raises UnusableFrame where it cannot tell."""

    def corrections(self) -> Mapping[int, Pose]:
        """Poses that changed since the last call, by frame index: the map must follow them."""

    def finish(self) -> None:
        """No more frames will come: the last corrections can be made."""

    def report(self) -> PoseReport | None:
        """What the estimation did since the last report; None where nothing is estimated."""


class GivenPoses:
    """The poses that the frames carry; they never change."""

    def locate(self, frame: Frame) -> Pose | None:
        """The frame's own pose; raises UnusableFrame where it has none."""
        return frame.pose

    def corrections(self) -> Mapping[int, Pose]:
        """Nothing: given poses are final."""
        return {}

    def finish(self) -> None:
        """Nothing is left to do."""

    def report(self) -> PoseReport | None:
        """Nothing: given poses are not estimated."""
        return None


@dataclass
class _Located:
    """A frame that was found in front of a keyframe, and the pose last told of it."""

    keyframe: int
    keyframe_from_camera: Array
    told: Array | None


@dataclass
class SlamSystem:
    """Odometry against keyframes, place recognition, and a pose graph (`method.md` section 2)."""

    keyframes: Keyframes = field(default_factory=Keyframes)
    camera: ColorCamera = field(default_factory=ColorCamera.nominal)
    graph: PoseGraph = field(default_factory=PoseGraph)

    def __post_init__(self) -> None:
        self._finder = FeatureFinder()
        self._closures = Closures(self.keyframes)
        self._tracking: Tracking | None = None
        self._located: dict[int, _Located] = {}
        self._ties = Ties()
        self._lost_for = 0  # frames that show something, since the last that was found
        self._missed = 0  # frames of any kind, since then
        self._piece = 0
        self._alert = 0
        self._travelled_m = 0.0
        self._moved = False  # whether keyframes moved since corrections were last told
        self._last_index: int | None = None
        self._found: Registration | None = None
        self._reported = True  # whether the graph was reported since it was last optimised
        self._finished = False

    def locate(self, frame: Frame) -> Pose | None:
        """world_from_camera of a frame as far as it is known now; None = lost, or in a piece not tied to the rest."""
        self._last_index, self._found = frame.index, None
        turning = self._tracking.turning_rad_s(frame.stamp) if self._tracking is not None else 0.0
        view = View.of(frame, self._finder, self.camera, turning)
        grids = view.grids()
        if not self._find(view, grids):
            return None
        tracking = self._tracking
        assert tracking is not None
        if tracking.reference.piece:
            self._alert -= 1
            if self._alert >= 0 or self._alert % RELAXED == 0:
                self._look_round(view, grids)
        self._work(PAIRS_PER_FRAME)
        pose = self._pose(tracking.reference.number, tracking.reference_from_camera)
        at_home = tracking.reference.piece == 0
        self._located[frame.index] = _Located(
            tracking.reference.number, tracking.reference_from_camera, pose if at_home else None
        )
        return pose if at_home else None

    def _pose(self, keyframe: int, keyframe_from_camera: Array) -> Array:
        return orthonormal(self.keyframes[keyframe].world_from_camera @ keyframe_from_camera)

    def _find(self, view: View, grids: Grids) -> bool:
        """Track the view, or find it again, or begin a new piece with it."""
        tracking = self._tracking
        if tracking is not None:
            found = tracking.follow(view, grids, self.keyframes, self.camera)
            if found is not None:
                self._follow(tracking, found, view, grids)
                return True
        self._missed += 1
        if self._resumed(view, grids):
            return True
        if int(grids[-1].valid.sum()) < MIN_READINGS or len(view.features) < MIN_CORNERS:
            return False
        self._lost_for += 1
        if self.keyframes.all and self._lost_for <= PATIENCE:
            return False
        self._begin_piece(view, grids)
        return True

    def _follow(self, tracking: Tracking, found: Registration, view: View, grids: Grids) -> None:
        self.camera, self._found = found.camera, found
        self._lost_for = self._missed = 0
        tracking.advance(found.target_from_source, view.stamp)
        self._travelled_m += length_m(tracking.step)
        if needs_keyframe(found) and int(grids[-1].valid.sum()) >= MIN_READINGS:
            before = tracking.reference
            pose = self._pose(before.number, found.target_from_source)
            keyframe = self.keyframes.add(view, grids, pose, before.piece, self._travelled_m)
            self.graph.add_keyframe(keyframe.number, pose)
            edge = Edge(before.number, keyframe.number, found.target_from_source, found.information, sure=True)
            self.graph.add_edge(edge)
            self._closures.add(keyframe)
            self._optimise()
            tracking.turn_to(keyframe, np.eye(4))

    def _resumed(self, view: View, grids: Grids) -> bool:
        """Whether the view, soon after tracking was lost, is in front of the same keyframe still."""
        before = self._tracking
        if before is None or self._missed > RESUME:
            return False
        guesses = [before.reference_from_camera]
        found = self._closures.seen_from(before.reference, view, grids, guesses, self.camera)
        if found is None or found.n_features < MIN_FEATURES or not before.may_move(found.target_from_source):
            return False
        self._tracking = Tracking(before.reference, found.target_from_source, np.eye(4), view.stamp)
        self._lost_for = self._missed = 0
        self._found = found
        return True

    def _look_round(self, view: View, grids: Grids) -> None:
        """Whether the view of a young piece shows a place of another piece."""
        tracking = self._tracking
        assert tracking is not None
        reference = tracking.reference
        others = [k.number for k in self.keyframes.all if k.piece != reference.piece]
        for number in self._closures.lookalikes(view.features, others):
            found = self._closures.seen_from(self.keyframes[number], view, grids, [], self.camera)
            if found is not None:
                moved = found.target_from_source @ inverse(tracking.reference_from_camera)
                edge = Edge(number, reference.number, moved, found.information)
                if self._hear(edge, view.index, found.score):
                    return

    def _begin_piece(self, view: View, grids: Grids) -> None:
        pose = np.eye(4)
        if self.keyframes.all:
            self._piece += 1
            pose = self.keyframes.all[-1].world_from_camera
        keyframe = self.keyframes.add(view, grids, pose, self._piece, self._travelled_m)
        self.graph.add_keyframe(keyframe.number, pose, adrift=self._piece > 0)
        self._closures.add(keyframe)
        self._optimise()
        self._tracking = Tracking(keyframe, np.eye(4), np.eye(4), view.stamp)
        self._lost_for = self._missed = 0
        self._alert = ALERT

    def _work(self, n_pairs: int) -> None:
        """Measure some of the pairs that wait."""
        for _ in range(min(n_pairs, len(self._closures))):
            edge = self._closures.measure_next(self.camera)
            if edge is None:
                continue
            if self.keyframes[edge.a].piece == self.keyframes[edge.b].piece:
                self.graph.add_edge(edge)
            else:
                self._hear(edge, self.keyframes[edge.b].view.index, 1.0)

    def _hear(self, edge: Edge, frame: int, strength: float) -> bool:
        """Take in that a view of one piece was found in another; whether that ties the two together."""
        self._alert = ALERT
        a, b = self.keyframes[edge.a], self.keyframes[edge.b]
        shift = a.world_from_camera @ edge.a_from_b @ inverse(b.world_from_camera)
        home_from_piece = shift if a.piece < b.piece else inverse(shift)
        home, piece = sorted((a.piece, b.piece))
        agreeing = self._ties.hear(home, piece, Witness(frame, edge, home_from_piece, strength))
        if not agreeing:
            return False
        best = agreeing[0].edge
        self._join(self.keyframes[best.a], self.keyframes[best.b], best)
        for witness in agreeing:
            self.graph.add_edge(witness.edge)
        self._ties.forget(piece)
        self._optimise()
        return True

    def _join(self, a: Keyframe, b: Keyframe, edge: Edge) -> None:
        """Two pieces turned out to be one: the later one moves to where the edge says."""
        keep, move = (a, b) if a.piece < b.piece else (b, a)
        keep_from_move = edge.a_from_b if keep is a else inverse(edge.a_from_b)
        shift = keep.world_from_camera @ keep_from_move @ inverse(move.world_from_camera)
        gone = move.piece
        self._moved, self._reported = True, False
        for keyframe in self.keyframes.all:
            if keyframe.piece == gone:
                keyframe.piece = keep.piece
                keyframe.world_from_camera = shift @ keyframe.world_from_camera
        self.graph.shift({k.number: k.world_from_camera for k in self.keyframes.all})

    def _optimise(self) -> None:
        self._take(self.graph.optimise())

    def _take(self, poses: Mapping[int, Array]) -> None:
        self._moved, self._reported = True, False
        for number, pose in poses.items():
            self.keyframes[number].world_from_camera = pose

    def corrections(self) -> Mapping[int, Pose]:
        """Poses of located frames that differ from what was told of them last, and those never told."""
        if not self._moved:
            return {}
        self._moved = False
        changed = {}
        for index, located in self._located.items():
            if self.keyframes[located.keyframe].piece:
                continue
            pose = self._pose(located.keyframe, located.keyframe_from_camera)
            off = None if located.told is None else inverse(located.told) @ pose
            if off is None or length_m(off) > MOVED_M or angle_deg(off) > MOVED_DEG:
                changed[index] = located.told = pose
        return changed

    def finish(self) -> None:
        """Measure all pairs that overlap, smooth over everything, and drop closures that proved false."""
        for _ in range(2):
            self._work(len(self._closures))
            self._optimise()
            self._closures.queue_neighbours()
        self._work(len(self._closures))
        self._optimise()
        poses = self.graph.smooth()
        good = [edge for edge in self.graph.edges if edge.sure or surprise(edge, poses) <= MAX_SURPRISE]
        if len(good) < len(self.graph.edges):
            self.graph.replace(good)
            poses = self.graph.smooth()
        self._take(poses)
        self._finished = True

    def report(self) -> PoseReport:
        """How the last frame was located; with it, after an optimisation, the pose graph, and the covariance of the
        newest keyframe, or of all once the estimation is finished."""
        located = None if self._last_index is None else self._located.get(self._last_index)
        graph = None
        if not self._reported:
            graph = GraphReport.of(self.keyframes.all, self.graph.edges, self.n_loops, self._covariances())
            self._reported = True
        pose = None if located is None else located.told
        return PoseReport(pose, None if self._found is None else Finding.of(self._found), graph)

    def _covariances(self) -> Mapping[int, Array]:
        if self._finished:
            return self.graph.covariances()
        newest = len(self.keyframes) - 1
        covariance = self.graph.covariance(newest)
        return {} if covariance is None else {newest: covariance}

    def trajectory(self) -> dict[int, Pose]:
        """world_from_camera of every frame that is tied to the first one, as known now."""
        return {
            index: self._pose(located.keyframe, located.keyframe_from_camera)
            for index, located in self._located.items()
            if self.keyframes[located.keyframe].piece == 0
        }

    @property
    def n_loops(self) -> int:
        """Edges that close a loop: between keyframes that tracking does not connect within a few steps."""
        return sum(edge.b - edge.a > RECENT for edge in self.graph.edges)
