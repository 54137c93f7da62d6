"""Metric scale of poses from images alone, whose unit is any: how far the camera moved by depth, against the poses."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace

from data_tools.checks.depth_scale import factor_from_motion
from data_tools.checks.sample import Sample
from data_tools.recordings.recorded_sequence import RecordedSequence
from data_tools.recordings.sequence import FrameIteration
from data_tools.trajectory_files.frame_poses import FramePoses
from razer.arrays import Float64Array
from razer.frame import Frame, Intrinsics

AS_WRITTEN = 0.05  # scales that differ by less from 1 are those of metres: phones err by a few per cent, too


@dataclass(frozen=True)
class _PosedFrames(FrameIteration):
    """The frames of a recording that have a pose: every tenth image, perhaps."""

    sequence: RecordedSequence
    indices: tuple[int, ...]
    has_poses = True

    @property
    def name(self) -> str:
        return self.sequence.name

    @property
    def intrinsics(self) -> Intrinsics:
        return self.sequence.intrinsics

    @property
    def depth_scale(self) -> float:
        return self.sequence.depth_scale

    def __len__(self) -> int:
        return len(self.indices)

    def __getitem__(self, index: int) -> Frame:
        return self.sequence[self.indices[index]]


def in_metres(sequence: RecordedSequence, found: FramePoses) -> tuple[FramePoses, str]:
    """Poses in metres, and what was done to bring them there. The camera's motion between frames is measured by
    features and depth; poses whose unit is a metre by that, and those of which it tells nothing, stay as they are."""
    posed = _PosedFrames(replace(sequence, pose_of=found, implausible={}), tuple(sorted(found.poses)))
    # Depth would have to be multiplied by this to fit the poses.
    factor = factor_from_motion(Sample.of(posed))
    if factor is None:
        return found, "taken as metres: the images do not tell their scale"
    if abs(factor.factor - 1) <= AS_WRITTEN or factor.low <= 1 <= factor.high:
        return found, "in metres, as depth confirms"
    scaled = {frame: _scaled(pose, 1 / factor.factor) for frame, pose in found.poses.items()}
    return replace(found, poses=scaled), f"multiplied by {1 / factor.factor:.4g} to be metres, as depth has it"


def _scaled(pose: Float64Array, scale: float) -> Float64Array:
    scaled = pose.copy()
    scaled[:3, 3] *= scale
    return scaled


def from_depth_camera(found: FramePoses, color_from_depth: Float64Array | None) -> FramePoses:
    """The poses of the depth camera beside the colour camera whose images the poses are of."""
    if color_from_depth is None:
        return found
    poses: Mapping[int, Float64Array] = {frame: pose @ color_from_depth for frame, pose in found.poses.items()}
    return replace(found, poses=poses)
