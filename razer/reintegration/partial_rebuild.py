"""Partial rebuild: a volume refilled from every n-th kept frame while the run goes on."""

from __future__ import annotations

from razer.arrays import Int32Array, Pose
from razer.detection.perception import Observation
from razer.volume.label_voting import vote
from razer.volume.space_carving import carve
from razer.volume.voxel_map import VoxelMap


class PartialRebuild:
    """A second volume, and the poses of the frames in it. Its votes go to the tracks as they are."""

    def __init__(self, voxels: VoxelMap, stride: int) -> None:
        self.voxels = voxels.empty_copy()
        self.stride = stride
        self.poses: list[Pose] = []

    @property
    def next_position(self) -> int:
        """Which of the kept frames comes next."""
        return len(self.poses) * self.stride

    def fuse(self, observation: Observation, owners: Int32Array, carve_every: int, withdraw_votes: bool) -> None:
        """Fuse the next frame, and let it vote and carve, as it did at first.

        Args:
            observation: What it showed, at its newest pose.
            owners: Tracks (N,) of its detections.
            carve_every: Replayed frames between passes that carve free space; 0 = never.
            withdraw_votes: Whether voxels lose votes of instances that the frame shows elsewhere.
        """
        self.voxels.integrate(observation.frame, observation.surface)
        vote(self.voxels, observation.surface, observation.lifted.detections, owners, withdraw_votes)
        self.poses.append(observation.frame.pose)
        if carve_every and len(self.poses) % carve_every == 0:
            carve(self.voxels, observation.surface)
