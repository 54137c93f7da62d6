"""What the state of a source of poses consists of."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial

from app.stored_state.state_codec import KnownObjects
from razer.frame import Intrinsics
from slam.backend.dynamic_masking import DynamicMasking
from slam.backend.given_uncertainty import GivenUncertainty
from slam.backend.inverted_index import InvertedIndex
from slam.backend.keyframe_map import KeyframeMap
from slam.backend.loop_closure import LoopClosure, WaitingPair
from slam.backend.place_recognition import PlaceRecognition
from slam.backend.pose_graph import Batch, PoseGraph
from slam.backend.submaps.local_map import LocalMap
from slam.backend.submaps.merge_hypotheses import MergeHypotheses, MergeHypothesis
from slam.backend.submaps.placement_check import PlacementCheck
from slam.backend.submaps.submap_merging import SubmapMerging
from slam.backend.submaps.submap_search import SubmapSearch
from slam.backend.verified_registration import VerifiedRegistration
from slam.config import SlamConfig
from slam.frontend.color_calibration import ColorCalibration
from slam.frontend.depth_pyramid import DepthPyramid
from slam.frontend.features import FeatureExtractor, Features, Readout
from slam.frontend.frame_tracker import FrameTracker
from slam.frontend.icp import IcpResult
from slam.frontend.keyframes import Keyframe, Keyframes, View
from slam.frontend.sparse_readings import SparseReadings
from slam.frontend.view_registration import ViewRegistration
from slam.frontend.wide_features import WideFeatures
from slam.located_frames import LocatedFrame, LocatedFrames
from slam.pose_edge import PoseEdge, PosePrior
from slam.pose_reporter import PoseReporter
from slam.refinement import Observed, RefinedPoses
from slam.report import GraphReport, TrackingQuality
from slam.sparse.solved_poses import SolvedPoses
from slam.system import SlamSystem
from slam.uncertainty.open_directions import OpenDirections
from slam.uncertainty.pose_uncertainty import CovarianceScale

CLASSES = (
    Batch, ColorCalibration, CovarianceScale, DepthPyramid, DynamicMasking, Features, FrameTracker, GivenUncertainty,
    GraphReport, IcpResult, Intrinsics, InvertedIndex, Keyframe, KeyframeMap, Keyframes, LocalMap, LocatedFrame,
    LocatedFrames, LoopClosure, MergeHypotheses, MergeHypothesis, Observed, OpenDirections, PlacementCheck,
    PlaceRecognition, PoseEdge, PoseGraph, PosePrior, PoseReporter, Readout, RefinedPoses, SlamSystem, SolvedPoses,
    SparseReadings, SubmapMerging, SubmapSearch, TrackingQuality, VerifiedRegistration, View, WaitingPair, WideFeatures,
)  # fmt: skip


def known_poses(config: SlamConfig) -> KnownObjects:
    """What a saved source of poses of these settings may speak of."""
    made: dict[type, Callable[[], object]] = {
        kind: partial(kind, config) for kind in (FeatureExtractor, ViewRegistration)
    }
    return KnownObjects.of(CLASSES, config, made)
