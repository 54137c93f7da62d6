"""Reintegration of frames at corrected poses, after BundleFusion: fused frames are kept and, once their poses were
corrected, fused anew elsewhere.

Open3D's volume bakes poses in, so a second one is filled beside it, a few frames at a time, and takes its place when
it has caught up. There is no clock here: work is counted in frames replayed, and during the run earned by frames
fused. What is rebuilt during the run takes its votes from the tracks as they are; at the end everything is mapped
once more, since what was matched while the map lay beside the poses may have been matched wrongly.
"""

from __future__ import annotations

from collections.abc import Generator, Mapping

from razer.arrays import Int32Array, Pose
from razer.config import MapperConfig
from razer.detection.perception import Observation
from razer.reintegration.adoption import adopt_tracks, adopt_volume
from razer.reintegration.kept_frames import Apply, KeptFrames
from razer.reintegration.partial_rebuild import PartialRebuild
from razer.stages import stage
from razer.tracking.panoptic_integrator import PanopticIntegrator


class Reintegrator:
    """Keeps frames, notes corrected poses, and rebuilds the map that a `PanopticIntegrator` holds."""

    def __init__(self, config: MapperConfig) -> None:
        self.settings = config.reintegration
        self.n_rebuilds = 0
        self._mapped_carve_every = config.voxels.carve_every
        self._withdraw_votes = config.maintenance.withdraw_votes
        self._frames = KeptFrames(config)
        self._fused_at: list[Pose] = []  # where each kept frame lies in the map that is shown
        self._replay_budget = 0.0
        self._rebuild: PartialRebuild | None = None
        # Whether the map shown is made of some of the kept frames only, or of frames that counted otherwise.
        self._is_rough = False
        self._corrected = False  # since the poses were last compared with the map
        self._moved = False

    @property
    def n_kept(self) -> int:
        """Frames kept so far."""
        return len(self._frames)

    @property
    def n_replays(self) -> int:
        """Kept frames fused once more so far."""
        return self._frames.n_replays

    @property
    def stored_bytes(self) -> int:
        """Bytes of the kept frames, in memory and in the file."""
        return self._frames.stored_bytes

    @property
    def is_behind(self) -> bool:
        """Whether the map lies where the poses no longer are, so that what is missed in it need not be gone."""
        return self._rebuild is not None or self._moved

    @property
    def is_final(self) -> bool:
        """Whether the map is as good as can be: of all kept frames, and none has moved since or counts otherwise."""
        if not self.n_kept:
            return not self._is_rough
        shift_voxels = self._frames.shift_voxels(self._frames.poses, self._fused_at).max()
        return not self._is_rough and bool(shift_voxels <= self.settings.min_final_shift_voxels)

    def keep(self, observation: Observation, owners: Int32Array) -> None:
        """Note a fused frame with the tracks (N,) of its detections, and keep it if enough has changed since the
        last."""
        self._replay_budget += self.settings.replays_per_frame
        if self._frames.offer(observation, owners):
            self._fused_at.append(observation.frame.pose)

    def move(self, corrections: Mapping[int, Pose | None]) -> None:
        """Note new world_from_camera (4, 4) of frames by index; those that were not kept are of no concern. Frames
        whose pose is None have no part in the map any more."""
        if forgotten := {index for index, pose in corrections.items() if pose is None}:
            self._fused_at = [self._fused_at[position] for position in self._frames.forget(forgotten)]
            self._rebuild, self._is_rough = None, True
        self._corrected |= self._frames.move(corrections)

    def weigh(self, weights: Mapping[int, float]) -> None:
        """Note how much frames count, by frame index, where that is less than in full."""
        self._is_rough |= self._frames.weigh(weights)

    def advance(self, integrator: PanopticIntegrator) -> list[tuple[int, int]] | None:
        """Rebuild a little, as the run goes on. Once a rebuilt volume has taken the place of the integrator's, returns
        the duplicates fused by that, (gone, survivor); else None."""
        if self._corrected:
            self._compare()
        if self._moved and self._rebuild is None and self._replay_budget >= self._rebuild_replays:
            self._rebuild = PartialRebuild(integrator.voxels, self.settings.keyframe_stride)
        if self._rebuild is None:
            return None
        for _ in range(self.settings.max_replays_per_frame):
            if self._rebuild.next_position < self.n_kept:
                self._replay_budget -= 1
                self._replay_into(self._rebuild)
        return self._adopt(self._rebuild, integrator) if self._rebuild.next_position >= self.n_kept else None

    def _compare(self) -> None:
        """Find out whether poses moved far enough to rebuild the map, or to start a rebuild under way over."""
        self._corrected = False
        self._moved = self._has_moved(self._frames.poses, self._fused_at)
        rebuild = self._rebuild
        if rebuild and rebuild.poses and self._replay_budget >= self._rebuild_replays:
            newest_poses = self._frames.poses[: rebuild.next_position : rebuild.stride]
            self._rebuild = None if self._has_moved(newest_poses, rebuild.poses) else rebuild

    @property
    def _rebuild_replays(self) -> int:
        """Frames that a rebuild during the run replays."""
        return len(range(0, self.n_kept, self.settings.keyframe_stride))

    def _has_moved(self, poses: list[Pose], fused_at: list[Pose]) -> bool:
        return bool(self._frames.shift_voxels(poses, fused_at).mean() > self.settings.min_shift_voxels)

    @property
    def _carve_every(self) -> int:
        """Replays between passes that carve free space, as often for what was observed; 0 = never."""
        every = self._mapped_carve_every
        return max(1, round(every / self._frames.frames_each)) if every else 0

    def _replay_into(self, rebuild: PartialRebuild) -> None:
        position = rebuild.next_position
        (observation,) = self._frames.replays(range(position, position + 1))
        rebuild.fuse(observation, self._frames.owners[position], self._carve_every, self._withdraw_votes)

    def _adopt(self, rebuild: PartialRebuild, integrator: PanopticIntegrator) -> list[tuple[int, int]]:
        """Show the rebuilt volume, whose observations and votes count for the frames that were left out as well."""
        rebuild.voxels.amplify(rebuild.stride * self._frames.frames_each)
        # A frame that was left out lies where it belongs: its neighbours stand for it.
        self._fused_at = [
            pose if i % rebuild.stride else rebuild.poses[i // rebuild.stride]
            for i, pose in enumerate(self._frames.poses)
        ]
        self._rebuild, self._is_rough, self._corrected = None, rebuild.stride > 1, True
        self.n_rebuilds += 1
        return adopt_volume(integrator, rebuild.voxels, self._frames.owners)

    def catch_up(self, integrator: PanopticIntegrator, apply: Apply = map) -> Generator[float]:
        """Map all kept frames once more at their final poses, unless the map `is_final`; yields the share done, after
        each frame. They are unpacked by `apply`. Instances keep their ids."""
        if self.is_final:
            return
        successor = integrator.successor(self._carve_every)
        owners: list[Int32Array] = []
        replays = self._frames.replays(range(self.n_kept), apply)
        if not self.n_kept:  # all are lost after all: what they showed is forgotten
            self._adopt_successor(integrator, successor, owners)
        for _ in range(self.n_kept):
            with stage("rebuild"):
                owners.append(successor.fuse(next(replays)).owners)
                if len(owners) == self.n_kept:
                    self._adopt_successor(integrator, successor, owners)
            yield len(owners) / self.n_kept

    def _adopt_successor(
        self, integrator: PanopticIntegrator, successor: PanopticIntegrator, owners: list[Int32Array]
    ) -> None:
        adopt_tracks(integrator, successor, self._frames.owners, owners)
        successor.voxels.amplify(self._frames.frames_each)
        self._frames.owners = owners
        self._fused_at = list(self._frames.poses)
        self._rebuild, self._is_rough, self._moved, self._corrected = None, False, False, False
        self.n_rebuilds += 1
        adopt_volume(integrator, successor.voxels, owners)
