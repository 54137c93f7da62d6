"""The camera's path from the frames alone: tracking against keyframes, loss and recovery, corrections."""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np

from razer.arrays import Float64Array
from razer.frame import Frame
from razer.geometry import inverse
from slam.backend.keyframe_map import KeyframeMap
from slam.backend.pose_graph import PoseGraph
from slam.frontend.color_calibration import ColorCamera
from slam.frontend.features import FeatureExtractor
from slam.frontend.frame_tracker import FrameTracker, needs_keyframe
from slam.frontend.icp import IcpResult
from slam.frontend.keyframes import STILL, Keyframe, Keyframes, View
from slam.frontend.view_registration import Grids
from slam.poses import Pose
from slam.report import GraphReport, PoseReport, TrackingQuality
from slam.se3 import angle_deg, length_m

PATIENCE = 2  # frames that show something but nothing known, after which a new submap of the map is begun
RESUME = 30  # frames after which the camera may be anywhere
MIN_READINGS, MIN_CORNERS = 500, 50  # valid depth pixels and corners that a submap must begin with
MIN_FEATURES = 20  # that agree, to go on where tracking was lost
MOVED_M, MOVED_DEG = 0.002, 0.1  # a correction worth telling
PAIRS_PER_FRAME = 1


@dataclass
class _Located:
    """A frame that was found in front of a keyframe, and the pose last told of it."""

    keyframe: int
    keyframe_from_camera: Float64Array
    told: Float64Array | None


@dataclass
class SlamSystem:
    """Odometry against keyframes, place recognition, and a pose graph (`method.md` section 2)."""

    map: KeyframeMap = field(default_factory=KeyframeMap)
    camera: ColorCamera = field(default_factory=ColorCamera.nominal)

    def __post_init__(self) -> None:
        self._finder = FeatureExtractor()
        self._tracking: FrameTracker | None = None
        self._located: dict[int, _Located] = {}
        self._lost_for = 0  # frames that show something, since the last that was found
        self._missed = 0  # frames of any kind, since then
        self._travelled_m = 0.0
        self._told_version = 0  # of the map's poses
        self._reported_version = 0
        self._last_index: int | None = None
        self._found: IcpResult | None = None
        self._finished = False

    @property
    def keyframes(self) -> Keyframes:
        """All keyframes."""
        return self.map.keyframes

    @property
    def graph(self) -> PoseGraph:
        """The pose graph over them."""
        return self.map.graph

    @property
    def n_loops(self) -> int:
        """Edges that close a loop."""
        return self.map.n_loops

    def locate(self, frame: Frame) -> Pose | None:
        """world_from_camera of a frame as far as it is known now; None = lost, or in a submap not tied to the rest."""
        self._last_index, self._found = frame.index, None
        turning = self._tracking.turning_rad_s(frame.stamp) if self._tracking is not None else STILL
        view = View.of(frame, self._finder, self.camera, turning)
        grids = view.grids()
        tracking = self._find(view, grids)
        if tracking is None:
            return None
        here, here_from_camera = tracking.reference, tracking.reference_from_camera
        if here.submap:
            self.map.look_round(view, grids, here, here_from_camera, self.camera)
        self.map.work(self.camera, PAIRS_PER_FRAME)
        pose = self.map.pose(here.number, here_from_camera) if here.submap == 0 else None
        self._located[frame.index] = _Located(here.number, here_from_camera, pose)
        return pose

    def _find(self, view: View, grids: Grids) -> FrameTracker | None:
        """Track the view, or find it again, or begin a new submap with it."""
        tracking = self._tracking
        found = None if tracking is None else tracking.follow(view, grids, self.keyframes, self.camera)
        if tracking is not None and found is not None:
            return self._follow(tracking, *found, grids)
        self._missed += 1
        if tracking is not None and self._missed <= RESUME:
            resumed = self._resumed(tracking, view, grids)
            if resumed is not None:
                return self._track(tracking.reference, resumed.target_from_source, view, resumed)
        if int(grids[-1].valid.sum()) < MIN_READINGS or len(view.features) < MIN_CORNERS:
            return None
        self._lost_for += 1
        if self.keyframes.all and self._lost_for <= PATIENCE:
            return None
        return self._track(self.map.begin_submap(view, grids, self._travelled_m), np.eye(4), view)

    def _track(
        self, reference: Keyframe, reference_from_camera: Float64Array, view: View, found: IcpResult | None = None
    ) -> FrameTracker:
        """Go on from a view in front of a keyframe, of whose motion nothing is known."""
        self._tracking = FrameTracker(reference, reference_from_camera, np.eye(4), view.stamp)
        self._found = found
        self._lost_for = self._missed = 0
        return self._tracking

    def _follow(self, tracking: FrameTracker, view: View, found: IcpResult, grids: Grids) -> FrameTracker:
        self.camera, self._found = found.camera, found
        self._lost_for = self._missed = 0
        tracking.advance(found.target_from_source, view.stamp)
        self._travelled_m += length_m(tracking.step)
        if needs_keyframe(found) and int(grids[-1].valid.sum()) >= MIN_READINGS:
            keyframe = self.map.extend(tracking.reference, view, grids, found, self._travelled_m)
            tracking.turn_to(keyframe, np.eye(4))
        return tracking

    def _resumed(self, before: FrameTracker, view: View, grids: Grids) -> IcpResult | None:
        """The view, soon after tracking was lost, in front of the same keyframe still."""
        found = self.map.seen_from(before.reference, view, grids, before.reference_from_camera, self.camera)
        if found is None or found.n_features < MIN_FEATURES or not before.may_move(found.target_from_source):
            return None
        return found

    def corrections(self) -> Mapping[int, Pose | None]:
        """Poses of located frames that differ from what was told of them last, those never told, and None for those
        that were told of a submap which is not the world any more."""
        if self._told_version == self.map.version:
            return {}
        self._told_version = self.map.version
        poses = self.trajectory()
        changed: dict[int, Pose | None] = {}
        for index, located in self._located.items():
            if located.told is not None and index not in poses:
                changed[index] = located.told = None
        for index, pose in poses.items():
            located = self._located[index]
            off = None if located.told is None else inverse(located.told) @ pose
            if off is None or length_m(off) > MOVED_M or angle_deg(off) > MOVED_DEG:
                changed[index] = located.told = pose
        return changed

    def finish(self) -> None:
        """Measure all pairs that overlap, smooth over everything, and drop closures that proved false. The submap that
        shows most frames is the world."""
        self.map.finish(self.camera)
        frames = Counter(self.keyframes[located.keyframe].submap for located in self._located.values())
        if frames and (largest := max(frames, key=lambda submap: (frames[submap], -submap))):
            self.map.make_world(largest)
        self._finished = True

    def trajectory(self) -> dict[int, Pose]:
        """world_from_camera of every frame of the world, as known now."""
        return {
            index: self.map.pose(located.keyframe, located.keyframe_from_camera)
            for index, located in self._located.items()
            if self.keyframes[located.keyframe].submap == 0
        }

    def report(self) -> PoseReport:
        """How the last frame was located; with it, after an optimisation, the pose graph, and the covariance of the
        newest keyframe, or of all once the estimation is finished."""
        located = None if self._last_index is None else self._located.get(self._last_index)
        graph = None
        if self._reported_version != self.map.version:
            graph = GraphReport.of(self.keyframes.all, self.graph.edges, self.n_loops, self._covariances())
            self._reported_version = self.map.version
        pose = None if located is None else located.told
        return PoseReport(pose, None if self._found is None else TrackingQuality.of(self._found), graph)

    def _covariances(self) -> Mapping[int, Float64Array]:
        if self._finished:
            return self.graph.covariances()
        newest = len(self.keyframes) - 1
        covariance = self.graph.covariance(newest)
        return {} if covariance is None else {newest: covariance}
