"""Poses by frame, as every kind of file ends: a plain value, as a sequence travels to other processes."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from data_tools.recordings.trajectories import PoseWithNotes, checked_pose
from razer.arrays import Float64Array
from razer.errors import UnusableFrame


@dataclass(frozen=True, slots=True)
class FramePoses:
    """The poses of a file, world_from_camera (4, 4), by the index of the frame that each belongs to."""

    source: str
    poses: Mapping[int, Float64Array]

    def __call__(self, index: int) -> PoseWithNotes:
        """The pose of a frame; raises UnusableFrame where it has none or no usable one."""
        if index not in self.poses:
            raise UnusableFrame(f"{self.source} has no pose of it")
        return checked_pose(self.poses[index], f"{self.source}, pose of frame {index}")
