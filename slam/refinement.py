"""Given poses as priors, corrected by registration: frames are tracked from the given motion, places seen again close
loops, and a pose graph weighs both against the given poses. The world is theirs."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from razer.arrays import Float64Array, Pose
from razer.frame import Frame
from razer.geometry import inverse
from slam.backend.given_uncertainty import GivenUncertainty
from slam.backend.keyframe_map import KeyframeMap
from slam.backend.pose_graph import PRIOR_HUBER, PoseGraph
from slam.config import SlamConfig
from slam.frontend.color_calibration import ColorCalibration
from slam.frontend.features import FeatureExtractor
from slam.frontend.frame_tracker import FrameTracker, needs_keyframe
from slam.frontend.icp import IcpResult
from slam.frontend.keyframes import MIN_POINTS, STILL, Keyframe, Keyframes, View
from slam.frontend.view_registration import ViewRegistration, is_trusted
from slam.located_frames import LocatedFrames
from slam.pose_edge import PoseEdge, edge_information
from slam.pose_reporter import PoseReporter
from slam.report import PoseReport
from slam.se3 import angle_deg, exp_se3, length_m, orthonormal, turn_rad

# Registrations that differ by more from the given motion are held against what fits there. As drift goes, it is a jump.
FAR_M, FAR_DEG = 0.05, 3.0
MIN_OVERLAP = 0.05  # that divides
AS_WELL, AS_MANY = 0.95, 0.8  # of the share of depth that fits, where views overlap, and of features


@dataclass(frozen=True)
class Observed:
    """What is known of a frame in front of a keyframe: the given motion keyframe_from_camera (4, 4), and the one that
    was registered with its information, None where that failed."""

    given: Float64Array
    measured: PoseEdge | None

    def motion(self, uncertainty: GivenUncertainty) -> Float64Array:
        """Both together: their mean by information, the given one counting the less the more they differ (Huber)."""
        if self.measured is None:
            return self.given
        offset = inverse(self.given) @ self.measured.a_from_b
        difference = np.concatenate([turn_rad(offset), offset[:3, 3]])
        sigmas = uncertainty.step_sigmas
        contradiction = float(np.linalg.norm(difference / sigmas))
        given = np.diag(sigmas**-2.0) * min(1.0, PRIOR_HUBER / max(contradiction, 1e-9))
        measured = edge_information(self.measured) / uncertainty.unit**2
        return orthonormal(self.given @ exp_se3(np.linalg.solve(given + measured, measured @ difference)))


class RefinedPoses:
    """The poses that frames carry, corrected."""

    def __init__(self, config: SlamConfig = SlamConfig()) -> None:  # noqa: B008
        self.config = config
        self.map = KeyframeMap(config, PoseGraph(fixed=None))
        self.calibration = ColorCalibration.nominal()
        self._extractor = FeatureExtractor(config)
        self._registration = ViewRegistration(config)
        self._uncertainty = GivenUncertainty.of(config.refinement)
        self._tracker: FrameTracker | None = None
        self._given = np.eye(4)  # of the last frame
        self._given_keyframes: dict[int, Float64Array] = {}
        self._observed: dict[int, Observed] = {}
        self._located = LocatedFrames(self.map)
        self._travelled_m = 0.0
        self._reporter = PoseReporter(self.map, self._located)

    @property
    def keyframes(self) -> Keyframes:
        """All keyframes."""
        return self.map.keyframes

    @property
    def n_loops(self) -> int:
        """Edges that close a loop."""
        return self.map.n_loops

    def locate(self, frame: Frame) -> Pose:
        """world_from_camera of a frame as far as it is known now; raises UnusableFrame where it has no given pose."""
        given = frame.pose
        self._reporter.begin(frame.index)
        tracker = self._tracker
        if tracker is None:
            tracker = self._tracker = self._begin(frame, given)
        else:
            tracker.step = inverse(self._given) @ given
            self._follow(tracker, frame, given)
        self._given = given
        self.map.close_loops(self.calibration, self.config.loop_closure.pairs_per_frame)
        pose = self._located.add(frame.index, tracker.reference, tracker.reference_from_camera)
        assert pose is not None  # there is one submap, the world
        return pose

    def _view(self, frame: Frame, turning_rad_s: Float64Array) -> View:
        features = self._extractor.extract(frame, self.calibration)
        return View.of(frame, features, turning_rad_s, self.config, self.calibration)

    def _begin(self, frame: Frame, given: Pose) -> FrameTracker:
        keyframe = self._add_keyframe(self._view(frame, STILL), given, given, None, None)
        # Given poses are a prior already, and know how far they may be trusted.
        return FrameTracker(self.keyframes, self._registration, keyframe, np.eye(4), frame.stamp, has_prior=False)

    def _follow(self, tracker: FrameTracker, frame: Frame, given: Pose) -> None:
        """Locate a frame from the given motion, or, where registration fails, by it."""
        by_given_motion = tracker.predicted()
        view = self._view(frame, tracker.turning_rad_s(frame.stamp))
        view, result = self._register(tracker, view, by_given_motion)
        reference = tracker.reference
        self._reporter.registered(result)
        edge = None if result is None else _edge(reference, len(self.keyframes), result)
        from_keyframe = inverse(self._given_keyframes[reference.number]) @ given
        observed = Observed(by_given_motion if edge is None else from_keyframe, edge)
        tracker.advance(observed.motion(self._uncertainty), frame.stamp)
        self._travelled_m += length_m(tracker.step)
        if (result is None or needs_keyframe(result, self.config.keyframes)) and view.pyramid.n_points >= MIN_POINTS:
            pose = self.map.pose(reference.number, tracker.reference_from_camera)
            tracker.turn_to(self._add_keyframe(view, pose, given, reference, edge), np.eye(4))
        else:
            self._observed[frame.index] = observed

    def _register(self, tracker: FrameTracker, view: View, given_motion: Float64Array) -> tuple[View, IcpResult | None]:
        """A view in front of the reference, looked for where the given motion leads, then where the camera was: given
        poses may jump."""
        followed = tracker.follow(view, self.calibration)
        if followed is None:
            tracker.step = np.eye(4)
            followed = tracker.follow(view, self.calibration)
        if followed is None:
            return view, None
        view, result = self._nearest_fit(tracker, *followed, given_motion)
        self.calibration = result.calibration
        return view, result

    def _nearest_fit(
        self, tracker: FrameTracker, view: View, result: IcpResult, given_motion: Float64Array
    ) -> tuple[View, IcpResult]:
        """What was registered, unless that is far from the given motion and depth fits there about as well: things
        repeat, and places look alike."""
        offset = inverse(given_motion) @ result.target_from_source
        if length_m(offset) <= FAR_M and angle_deg(offset) <= FAR_DEG:
            return view, result
        target = self.keyframes.view(tracker.reference)
        there = self._registration.refine(target, view, given_motion, self.calibration)
        return view, there if is_trusted(there) and _fits_as_well(there, result) else result

    def _add_keyframe(
        self, view: View, pose: Float64Array, given: Pose, before: Keyframe | None, edge: PoseEdge | None
    ) -> Keyframe:
        number = len(self.keyframes)
        self._given_keyframes[number] = given
        priors = self._uncertainty.priors(self._given_keyframes, number, None if before is None else before.number)
        self.keyframes.recolor(self.calibration)
        return self.map.place(view, pose, self._travelled_m, [] if edge is None else [edge], priors)

    def corrections(self) -> Mapping[int, Pose | None]:
        """Poses of located frames that differ from those reported last."""
        return self._located.corrections()

    def finish(self) -> None:
        """Measure the pairs that overlap and add something, drop closures that proved false, measure how far the given
        poses are to be believed, and smooth over everything once more by that."""
        self.map.finish(self.calibration)
        given, graph = self._given_keyframes, self.map.graph
        self._uncertainty = self._uncertainty.measured(given, graph.edges, graph.poses)
        neighbours = {prior.b: prior.a for prior in graph.priors if prior.a is not None}
        priors = [prior for n in given for prior in self._uncertainty.priors(given, n, neighbours.get(n))]
        self.map.smooth(priors)
        for index, observed in self._observed.items():
            self._located.move(index, observed.motion(self._uncertainty))
        self._reporter.is_finished = True

    def trajectory(self) -> dict[int, Pose]:
        """world_from_camera of every frame, as known now."""
        return self._located.trajectory()

    def report(self) -> PoseReport:
        """How the last frame was registered; with it, after an optimisation, the pose graph, and the covariance of the
        newest keyframe, or of all once the estimation is finished."""
        return self._reporter.report()


def _edge(reference: Keyframe, number: int, result: IcpResult) -> PoseEdge:
    """What tracking measured, as an edge from a keyframe to the one that may follow."""
    return PoseEdge(reference.number, number, result.target_from_source, result.information, is_odometry=True)


def _fits_as_well(there: IcpResult, result: IcpResult) -> bool:
    """Whether one registration is about as good as another one. What overlaps less is no worse for that: depth that
    slides along a wall slides to where it overlaps most."""
    fits, best = (one.fit / max(one.overlap, MIN_OVERLAP) for one in (there, result))
    return fits >= AS_WELL * best and there.n_features >= AS_MANY * result.n_features
