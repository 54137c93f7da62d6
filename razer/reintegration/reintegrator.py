"""The map follows the poses: fused frames are kept and, once their poses were corrected, fused anew elsewhere.

Open3D's volume bakes poses in, so a second one is filled beside it, a few frames at a time, and takes its place when
it has caught up. There is no clock here: work is counted in frames replayed, and during the run earned by frames
fused. What is rebuilt during the run takes its votes from the tracks as they are; at the end everything is mapped
once more (`Mapper.catch_up`), since what was matched while the map lay beside the poses may have been matched wrongly.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from concurrent.futures import Future, ThreadPoolExecutor
from functools import partial

import numpy as np

from razer.arrays import Float64Array, Int32Array, Pose
from razer.config import MapperConfig
from razer.detection.perception import Observation
from razer.reintegration.frame_codec import pack, unpack
from razer.reintegration.frame_store import FrameStore
from razer.volume.label_voting import vote
from razer.volume.space_carving import carve
from razer.volume.voxel_map import VoxelMap

# Does pure work on each of some items, in order; `map`, or something that works ahead.
Apply = Callable[[Callable[[tuple[bytes, Pose]], Observation], Iterable[tuple[bytes, Pose]]], Iterable[Observation]]

# Where the shift of a view is measured: the middle and the corners of an image 2 m away.
PROBES = np.array([[0, 0, 2, 1], [-1, -0.75, 2, 1], [1, -0.75, 2, 1], [-1, 0.75, 2, 1], [1, 0.75, 2, 1]]).T
# Of a fast camera each frame is needed, as its neighbours do not show the same; one at rest shows nothing new, and
# its frames are kept several times more rarely. Shift since the last kept frame, voxels at 2 m depth.
FAST_VOXELS = 2.5
RESTING_VOXELS = 0.5
RESTING = 4


def shifts_m(before: Float64Array, after: Float64Array) -> Float64Array:
    """How far what N cameras see at 2 m depth moves, metres (N,), if their poses (N, 4, 4) change."""
    return np.linalg.norm(((after - before) @ PROBES)[:, :3], axis=1).mean(axis=1)


class _Draft:
    """A volume being filled with every `stride`-th kept frame, and the poses they were fused at."""

    def __init__(self, voxels: VoxelMap, stride: int) -> None:
        self.voxels = voxels.empty_copy()
        self.stride = stride
        self.next = 0
        self.replays = 0
        self.poses: list[Pose] = []


class Reintegrator:
    """The kept frames of a map, their newest poses, and the volume that is being rebuilt from them."""

    def __init__(self, config: MapperConfig) -> None:
        self.settings, self.voxel_settings = config.reintegration, config.voxels
        self._withdraw_votes = config.maintenance.withdraw_votes
        self._store = FrameStore(config.reintegration.memory_mb * 10**6)
        self._packer = ThreadPoolExecutor(1)  # compressing holds no lock, and the next frame need not wait for it
        self._being_packed: Future[bytes] | None = None
        self._stored: list[int] = []  # where in the store each kept frame is
        self.owners: list[Int32Array] = []  # tracks of the detections of each kept frame
        self._position: dict[int, int] = {}  # of a frame index among the kept frames
        self._poses: list[Pose] = []  # newest
        self._fused_at: list[Pose] = []  # in the map that is shown
        self._since_kept = 0
        self._stood_for = 0  # fused frames that the kept ones stand for, without those of a resting camera
        self._earned = 0.0
        self._draft: _Draft | None = None
        self._is_rough = False  # whether the map shown is a draft
        self._corrected = False  # since the poses were last compared with the map
        self._moved = False
        self.n_rebuilds = 0
        self.n_replays = 0

    @property
    def n_kept(self) -> int:
        """Frames kept so far."""
        return len(self._poses)

    @property
    def carve_every(self) -> int:
        """Replays between passes that forget what is free space now, as often for what was seen; 0 = never."""
        every = self.voxel_settings.carve_every
        return max(1, round(every / self._frames_each)) if every else 0

    @property
    def _frames_each(self) -> float:
        """How many fused frames one kept frame stands for."""
        return self._stood_for / self.n_kept

    @property
    def stored_bytes(self) -> int:
        """What the kept frames take, in memory and in the file."""
        store = self._all_stored()
        return store.memory_bytes + store.spilled_bytes

    @property
    def is_behind(self) -> bool:
        """Whether the map lies where the poses no longer are, so that what is missed in it need not be gone."""
        return self._draft is not None or self._moved

    def keep(self, seen: Observation, owners: Int32Array) -> None:
        """Note a fused frame with the tracks (N,) of its detections, and keep it if enough has changed since the
        last."""
        frame = seen.frame
        self._earned += self.settings.replays_per_frame
        self._since_kept += 1
        if self._poses and self._since_kept < self._patience(frame.pose):
            return
        self._stood_for += min(self._since_kept, self.settings.frames_per_keyframe)
        self._since_kept = 0
        self._position[frame.index] = len(self._poses)
        self.owners.append(owners)
        self._stored.append(len(self._all_stored()))
        self._being_packed = self._packer.submit(pack, seen)
        self._poses.append(frame.pose)
        self._fused_at.append(frame.pose)

    def _all_stored(self) -> FrameStore:
        """The store with the frame in it that was kept last."""
        if self._being_packed is not None:
            self._store.append(self._being_packed.result())
            self._being_packed = None
        return self._store

    def _patience(self, pose: Pose) -> int:
        """After how many fused frames one is kept."""
        shift_voxels = self._shift_voxels(self._poses[-1:], [pose])[0]
        if shift_voxels > FAST_VOXELS:
            return 1
        return self.settings.frames_per_keyframe * (RESTING if shift_voxels < RESTING_VOXELS else 1)

    def move(self, corrections: Mapping[int, Pose | None]) -> None:
        """Note new world_from_camera (4, 4) of frames by index; those that were not kept are of no concern. Frames
        whose pose is None have no part in the map any more."""
        self._forget({index for index, pose in corrections.items() if pose is None})
        for index, pose in corrections.items():
            if pose is not None and index in self._position:
                self._poses[self._position[index]] = pose
                self._corrected = True

    def _forget(self, frames: set[int]) -> None:
        if not frames:
            return
        kept = [(index, position) for index, position in self._position.items() if index not in frames]
        positions = [position for _, position in kept]
        self._stood_for = round(self._stood_for * len(kept) / max(self.n_kept, 1))
        self._position = {index: number for number, (index, _) in enumerate(kept)}
        self.owners = [self.owners[position] for position in positions]
        self._stored = [self._stored[position] for position in positions]
        self._poses = [self._poses[position] for position in positions]
        self._fused_at = [self._fused_at[position] for position in positions]
        self._draft, self._is_rough = None, True

    def _shift_voxels(self, poses: list[Pose], others: list[Pose]) -> Float64Array:
        return shifts_m(np.stack(poses), np.stack(others)) / self.voxel_settings.voxel_size_m

    def advance(self, voxels: VoxelMap) -> VoxelMap | None:
        """Rebuild a little, as the run goes on; returns what is to replace `voxels` once it has caught up."""
        if self._corrected:
            self._compare()
        if self._moved and self._draft is None and self._earned >= self._draft_replays:
            self._draft = _Draft(voxels, self.settings.keyframe_stride)
        if self._draft is None:
            return None
        for _ in range(self.settings.max_replays_per_frame):
            if self._draft.next < self.n_kept:
                self._earned -= 1
                self._fill(self._draft)
        return self._taken(self._draft) if self._draft.next >= self.n_kept else None

    def _compare(self) -> None:
        """Find out whether the map is worth rebuilding, and a rebuild under way worth starting over."""
        self._corrected = False
        self._moved = self._has_moved(self._poses, self._fused_at)
        draft = self._draft
        if draft and draft.poses and self._earned >= self._draft_replays:
            stale = self._has_moved(self._poses[: draft.next : draft.stride], draft.poses)
            self._draft = None if stale else draft

    @property
    def _draft_replays(self) -> int:
        return len(range(0, self.n_kept, self.settings.keyframe_stride))

    def _has_moved(self, poses: list[Pose], fused_at: list[Pose]) -> bool:
        return bool(self._shift_voxels(poses, fused_at).mean() > self.settings.min_shift_voxels)

    @property
    def is_final(self) -> bool:
        """Whether the map is as good as can be: made of all kept frames, and none has moved since."""
        if not self._poses:
            return not self._is_rough
        shift_voxels = self._shift_voxels(self._poses, self._fused_at).max()
        return not self._is_rough and bool(shift_voxels <= self.settings.min_final_shift_voxels)

    def replays(self, positions: range, apply: Apply = map) -> Iterator[Observation]:
        """What kept frames showed, at their newest poses."""
        store = self._all_stored()
        packed_at = ((store[self._stored[position]], self._poses[position]) for position in positions)
        for seen in apply(partial(unpack, settings=self.voxel_settings), packed_at):
            self.n_replays += 1
            yield seen

    def mapped_again(self, voxels: VoxelMap, owners: Sequence[Int32Array]) -> None:
        """Note that `voxels` were filled with all replays, whose detections went to `owners`."""
        voxels.amplify(self._frames_each)
        self.owners = list(owners)
        self._fused_at = list(self._poses)
        self._draft, self._is_rough, self._moved, self._corrected = None, False, False, False
        self.n_rebuilds += 1

    def _fill(self, draft: _Draft) -> None:
        """Fuse one kept frame, and let it vote and carve, as it did at first."""
        (seen,) = self.replays(range(draft.next, draft.next + 1))
        draft.voxels.integrate(seen.frame, seen.surface)
        vote(draft.voxels, seen.surface, seen.lifted.detections, self.owners[draft.next], self._withdraw_votes)
        draft.next += draft.stride
        draft.replays += 1
        draft.poses.append(seen.frame.pose)
        if self.carve_every and draft.replays % self.carve_every == 0:
            carve(draft.voxels, seen.surface)

    def _taken(self, draft: _Draft) -> VoxelMap:
        """The finished volume, whose observations and votes count for the frames that were left out as well."""
        draft.voxels.amplify(draft.stride * self._frames_each)
        # A frame that was left out lies where it belongs: its neighbours stand for it.
        self._fused_at = [
            pose if i % draft.stride else draft.poses[i // draft.stride] for i, pose in enumerate(self._poses)
        ]
        self._draft, self._is_rough, self._corrected = None, draft.stride > 1, True
        self.n_rebuilds += 1
        return draft.voxels
