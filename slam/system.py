"""Sparse RGB-D SLAM: frame-to-keyframe odometry, relocalisation, loop closure, pose-graph corrections."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from razer.arrays import Float64Array, Pose
from razer.frame import Frame
from razer.geometry import inverse
from slam.backend.keyframe_map import KeyframeMap
from slam.backend.pose_graph import PoseGraph
from slam.config import SlamConfig
from slam.frontend.color_calibration import ColorCalibration
from slam.frontend.features import FeatureExtractor
from slam.frontend.frame_tracker import FrameTracker, keyframe_nearby, needs_keyframe
from slam.frontend.icp import IcpResult
from slam.frontend.keyframes import MIN_POINTS, STILL, Keyframe, Keyframes, LocatedView, View
from slam.frontend.view_registration import ViewRegistration, is_trusted, leaves_open
from slam.located_frames import LocatedFrames
from slam.pose_reporter import PoseReporter
from slam.report import PoseReport
from slam.se3 import length_m

MIN_CORNERS = 50  # of colour, too, or depth that by itself holds the camera in every direction
NO_MATCHES = np.zeros((0, 2), np.intp)
MIN_FEATURES = 20  # that agree, to go on where tracking was lost: depth alone slides along walls


class SlamSystem:
    """Poses of frames by odometry against keyframes, place recognition, and a pose graph."""

    def __init__(self, config: SlamConfig = SlamConfig()) -> None:  # noqa: B008
        self.config = config
        self.map = KeyframeMap(config)
        self.calibration = ColorCalibration.nominal()
        self._extractor = FeatureExtractor(config)
        self._registration = ViewRegistration(config)
        self._tracker: FrameTracker | None = None
        self._located = LocatedFrames(self.map)
        self._passed: list[View] = []  # frames that show something, since the last that was located
        self._n_missed = 0  # frames of any kind, since then
        self._travelled_m = 0.0
        self._reporter = PoseReporter(self.map, self._located)

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
        """world_from_camera of a frame as far as it is known now; None = lost, or in an unanchored submap."""
        self._reporter.begin(frame.index)
        turning = STILL if self._tracker is None else self._tracker.turning_rad_s(frame.stamp)
        view = View.of(frame, self._extractor.extract(frame, self.calibration), turning, self.config, self.calibration)
        tracker = self._track(view)
        if tracker is None:
            return None
        located = LocatedView(view, tracker.reference, tracker.reference_from_camera)
        n_pairs = self.config.loop_closure.pairs_per_frame
        if located.reference.submap:
            self.map.search_submaps(located, self.calibration)
            n_pairs -= 1  # the search takes as long as a pair, or longer
        self.map.close_loops(self.calibration, max(n_pairs, 0))
        return self._located.add(frame.index, located.reference, located.reference_from_camera)

    def _track(self, view: View) -> FrameTracker | None:
        """Follow the camera to the view, or resume tracking with it, or begin a new submap."""
        tracker, submaps = self._tracker, self.config.submaps
        if tracker is not None and self._n_missed == 0:
            followed = tracker.follow(view, self.calibration)
            if followed is not None:
                return self._advance(tracker, *followed)
        self._n_missed += 1
        if tracker is not None and self._n_missed <= submaps.resume_frames:
            resumed = self._resume(tracker, view)
            if resumed is not None:
                return self._go_on(*resumed, view)
        if not self._may_begin(view):
            return None
        if self.keyframes.all and len(self._passed) < submaps.patience_frames:
            self._passed.append(view)
            return None
        return self._start(self.map.begin_submap(view, self._travelled_m), np.eye(4), view)

    def _may_begin(self, view: View) -> bool:
        """Whether something can follow a submap that begins with a view. Depth alone is enough in recordings that have
        no more than that: in others it is a hand before the lens as soon as a room without light."""
        if view.pyramid.n_points < MIN_POINTS:
            return False
        if len(view.features) >= MIN_CORNERS:
            return True
        has_color = self._tracker is not None and len(self._tracker.reference.view.features) >= MIN_CORNERS
        if has_color:
            return False
        return not leaves_open(self._registration.fit(view, view, np.eye(4), self.calibration, NO_MATCHES))

    def _go_on(self, keyframe: Keyframe, result: IcpResult, view: View) -> FrameTracker:
        """Track from a view that was found in front of a keyframe. After longer gaps it may be a look-alike."""
        if self._n_missed <= self.config.submaps.patience_frames or view.pyramid.n_points < MIN_POINTS:
            return self._start(keyframe, result.target_from_source, view, result)
        return self._start(self.map.resume(keyframe, view, result, self._travelled_m), np.eye(4), view, result)

    def _start(
        self, reference: Keyframe, reference_from_camera: Float64Array, view: View, result: IcpResult | None = None
    ) -> FrameTracker:
        """Track from a view in front of a keyframe, of whose motion nothing is known."""
        self._tracker = FrameTracker(self.keyframes, self._registration, reference, reference_from_camera, view.stamp)
        self._reporter.registered(result)
        self._locate_passed(self._tracker)
        self._n_missed = 0
        return self._tracker

    def _locate_passed(self, tracker: FrameTracker) -> None:
        """Locate the frames that were passed over while nobody knew where the camera was, back from where it is now."""
        guess = tracker.reference_from_camera
        while self._passed:
            view = self._passed.pop()
            result = self.map.recognise(tracker.reference, view, guess, self.calibration)
            if result is None or result.n_features < MIN_FEATURES:
                continue
            guess = result.target_from_source
            self._located.add_late(view.index, tracker.reference, guess)

    def _advance(self, tracker: FrameTracker, view: View, result: IcpResult) -> FrameTracker:
        self.calibration = result.calibration
        self._reporter.registered(result)
        self._n_missed = 0
        tracker.advance(result.target_from_source, view.stamp)
        self._travelled_m += length_m(tracker.step)
        if needs_keyframe(result, self.config.keyframes) and view.pyramid.n_points >= MIN_POINTS:
            tracker.turn_to(*(self._known(tracker, view) or self._added(tracker, view, result)))
        return tracker

    def _added(self, tracker: FrameTracker, view: View, result: IcpResult) -> tuple[Keyframe, Float64Array]:
        return self.map.extend(tracker.reference, view, result, self._travelled_m), np.eye(4)

    def _known(self, tracker: FrameTracker, view: View) -> tuple[Keyframe, Float64Array] | None:
        """A keyframe of before that shows what the view does from nearly there, and keyframe_from_camera (4, 4)."""
        reference, reference_from_camera = tracker.reference, tracker.reference_from_camera
        keyframe = keyframe_nearby(self.keyframes, reference, reference_from_camera, self.config.keyframes)
        if keyframe is None:
            return None
        guess = inverse(keyframe.world_from_camera) @ reference.world_from_camera @ reference_from_camera
        result = self._registration.refine(self.keyframes.view(keyframe), view, guess, self.calibration)
        if not is_trusted(result) or leaves_open(result) or needs_keyframe(result, self.config.keyframes):
            return None
        fits = self.map.tie(keyframe, reference, result.target_from_source @ inverse(reference_from_camera))
        return (keyframe, result.target_from_source) if fits else None

    def _resume(self, tracker: FrameTracker, view: View) -> tuple[Keyframe, IcpResult] | None:
        """The view, soon after tracking was lost, in front of one of the keyframes round about."""
        reference = tracker.reference
        for keyframe in self.map.around(reference, tracker.reference_from_camera, view):
            keyframe_from_reference = inverse(keyframe.world_from_camera) @ reference.world_from_camera
            guess = keyframe_from_reference @ tracker.reference_from_camera
            result = self.map.recognise(keyframe, view, guess, self.calibration)
            if result is None or result.n_features < MIN_FEATURES:
                continue
            if tracker.may_move(inverse(keyframe_from_reference) @ result.target_from_source):
                return keyframe, result
        return None

    def corrections(self) -> Mapping[int, Pose | None]:
        """Poses of located frames that differ from those reported last, those never reported, and None for those
        reported in a submap that is not the world any more."""
        return self._located.corrections()

    def finish(self) -> None:
        """Measure the pairs that overlap and add something, smooth over everything, and drop loop closures that proved
        false. The submap that shows most frames is the world."""
        self.map.finish(self.calibration)
        frames = self._located.submaps()
        if frames and (largest := max(frames, key=lambda submap: (frames[submap], -submap))):
            self.map.make_world(largest)
        self._reporter.is_finished = True

    def trajectory(self) -> dict[int, Pose]:
        """world_from_camera of every frame of the world, as known now."""
        return self._located.trajectory()

    def report(self) -> PoseReport:
        """How the last frame was located; with it, after an optimisation, the pose graph, and the covariance of the
        newest keyframe, or of all once the estimation is finished."""
        return self._reporter.report()
