"""What the state of a timeline consists of."""

from __future__ import annotations

from app.stored_state.state_codec import KnownObjects
from app.timeline.growing_map import GrowingMap
from app.timeline.map_chunks import ChunkSchedule
from app.timeline.objects.object_history import Life, ObjectHistory
from app.timeline.performance_log import PerformanceLog
from app.timeline.poses.pose_estimation_log import PoseEstimationLog
from app.timeline.poses.trajectory_lines import TrajectoryLines
from app.timeline.rerun_timeline import Timeline
from app.timeline.summary import RunSummary
from razer.mesh.labelled_mesh import LabelledMesh
from razer.mesh.mesh_chunks import Chunk
from slam.report import TrackingQuality

CLASSES = (
    Chunk, ChunkSchedule, GrowingMap, LabelledMesh, Life, ObjectHistory, PerformanceLog, PoseEstimationLog, RunSummary,
    TrackingQuality, TrajectoryLines,
)  # fmt: skip


def known_timeline(timeline: Timeline) -> KnownObjects:
    """What the state of a timeline may speak of; it refers to the log and to the settings that the timeline has."""
    return KnownObjects.of(CLASSES, log=timeline.log, timeline_settings=timeline.settings)
