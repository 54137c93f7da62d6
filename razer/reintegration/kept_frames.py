"""Keyframe selection and storage for reintegration: which fused frames are kept, what they showed, and their newest
poses."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping
from concurrent.futures import Future, ThreadPoolExecutor
from dataclasses import replace
from functools import partial
from typing import Any

import numpy as np

from razer.arrays import Float64Array, Int32Array, Pose
from razer.config import MapperConfig
from razer.detection.perception import Observation
from razer.reintegration.frame_codec import pack, unpack
from razer.reintegration.frame_store import FrameStore

# Does pure work on each of some items, in order; `map`, or something that works ahead.
Apply = Callable[[Callable[[tuple[bytes, Pose]], Observation], Iterable[tuple[bytes, Pose]]], Iterable[Observation]]

# Where the shift of a view is measured: the middle and the corners of an image 2 m away.
PROBES = np.array([[0, 0, 2, 1], [-1, -0.75, 2, 1], [1, -0.75, 2, 1], [-1, 0.75, 2, 1], [1, 0.75, 2, 1]]).T
# Of a fast camera each frame is needed, as its neighbours do not show the same; one at rest shows nothing new, and
# its frames are kept several times more rarely. Shift since the last kept frame, voxels at 2 m depth.
FAST_VOXELS = 2.5
RESTING_VOXELS = 0.5
RESTING_FACTOR = 4


def shifts_m(before: Float64Array, after: Float64Array) -> Float64Array:
    """How far what N cameras show at 2 m depth moves, metres (N,), if their poses (N, 4, 4) change."""
    return np.linalg.norm(((after - before) @ PROBES)[:, :3], axis=1).mean(axis=1)


class KeptFrames:
    """The kept frames in the order they came: observations, newest poses, and the tracks of their detections."""

    def __init__(self, config: MapperConfig) -> None:
        self.poses: list[Pose] = []  # newest
        self.owners: list[Int32Array] = []  # tracks of the detections of each
        self.n_replays = 0
        self._settings, self._voxel_settings, self._lifting = config.reintegration, config.voxels, config.lifting
        self._store = FrameStore(config.reintegration.memory_mb * 10**6)
        self._packer = ThreadPoolExecutor(1)  # compressing holds no lock, and the next frame need not wait for it
        self._being_packed: Future[bytes] | None = None
        self._store_rows: list[int] = []  # where in the store each kept frame is
        self._position: dict[int, int] = {}  # of a frame index among the kept frames
        self._weights: dict[int, float] = {}  # of those that count less than in full, by frame index
        self._since_kept = 0
        self._n_represented = 0  # fused frames that the kept ones stand for, without those of a resting camera

    def __getstate__(self) -> dict[str, Any]:
        self._complete_store()
        return {name: value for name, value in vars(self).items() if name not in ("_packer", "_being_packed")}

    def __setstate__(self, state: dict[str, Any]) -> None:
        vars(self).update(state, _packer=ThreadPoolExecutor(1), _being_packed=None)

    def __len__(self) -> int:
        return len(self.poses)

    @property
    def frames_each(self) -> float:
        """How many fused frames one kept frame stands for; 1 where none is kept, since all are lost after all."""
        return self._n_represented / len(self) if len(self) else 1.0

    @property
    def stored_bytes(self) -> int:
        """Bytes of all packed frames, in memory and in the file."""
        store = self._complete_store()
        return store.memory_bytes + store.spilled_bytes

    def offer(self, observation: Observation, owners: Int32Array) -> bool:
        """Keep a fused frame with the tracks (N,) of its detections if enough has changed since the last; returns
        whether it was kept."""
        frame = observation.frame
        self._since_kept += 1
        if self.poses and self._since_kept < self._interval(frame.pose):
            return False
        self._n_represented += min(self._since_kept, self._settings.frames_per_keyframe)
        self._since_kept = 0
        self._position[frame.index] = len(self.poses)
        self.owners.append(owners)
        self._store_rows.append(len(self._complete_store()))
        self._being_packed = self._packer.submit(pack, observation)
        self.poses.append(frame.pose)
        return True

    def _interval(self, pose: Pose) -> int:
        """After how many fused frames the next is kept, if the camera is at `pose` now."""
        shift_voxels = self.shift_voxels(self.poses[-1:], [pose])[0]
        if shift_voxels > FAST_VOXELS:
            return 1
        return self._settings.frames_per_keyframe * (RESTING_FACTOR if shift_voxels < RESTING_VOXELS else 1)

    def _complete_store(self) -> FrameStore:
        """The store with the frame in it that was kept last."""
        if self._being_packed is not None:
            self._store.append(self._being_packed.result())
            self._being_packed = None
        return self._store

    def shift_voxels(self, poses: list[Pose], others: list[Pose]) -> Float64Array:
        """How far views at 2 m depth move from `poses` to `others`, in voxels (N,)."""
        return shifts_m(np.stack(poses), np.stack(others)) / self._voxel_settings.voxel_size_m

    def move(self, corrections: Mapping[int, Pose | None]) -> bool:
        """Note new world_from_camera (4, 4) by frame index; returns whether a kept frame is among them."""
        moved = {
            self._position[index]: pose
            for index, pose in corrections.items()
            if pose is not None and index in self._position
        }
        for position, pose in moved.items():
            self.poses[position] = pose
        return bool(moved)

    def weigh(self, weights: Mapping[int, float]) -> bool:
        """Note how much frames count, by frame index, where that is less than in full; returns whether that changes
        what a kept frame counts."""
        changed = any(weights.get(index, 1.0) != self._weights.get(index, 1.0) for index in self._position)
        self._weights = dict(weights)
        return changed

    def forget(self, frame_indices: set[int]) -> list[int]:
        """Drop frames, by frame index; returns the former positions of the kept frames that are left."""
        left = [(index, position) for index, position in self._position.items() if index not in frame_indices]
        positions = [position for _, position in left]
        self._n_represented = round(self._n_represented * len(left) / max(len(self), 1))
        self._position = {index: number for number, (index, _) in enumerate(left)}
        self.owners = [self.owners[position] for position in positions]
        self._store_rows = [self._store_rows[position] for position in positions]
        self.poses = [self.poses[position] for position in positions]
        return positions

    def replays(self, positions: range, apply: Apply = map) -> Iterator[Observation]:
        """What kept frames showed, at their newest poses, counting as much as they do now."""
        store = self._complete_store()
        packed_at = ((store[self._store_rows[position]], self.poses[position]) for position in positions)
        for observation in apply(partial(unpack, settings=self._voxel_settings, lifting=self._lifting), packed_at):
            self.n_replays += 1
            yield self._weighed(observation)

    def _weighed(self, observation: Observation) -> Observation:
        weight = self._weights.get(observation.frame.index, 1.0)
        return observation if weight == 1 else replace(observation, frame=replace(observation.frame, weight=weight))
