"""Located frames: each in front of a keyframe, with the pose last reported for it; only those whose keyframe moved are
looked at again."""

from __future__ import annotations

from collections import Counter, defaultdict
from dataclasses import dataclass

import numpy as np

from razer.arrays import Float64Array, Pose
from razer.geometry import inverse
from slam.backend.keyframe_map import KeyframeMap
from slam.frontend.keyframes import Keyframe
from slam.se3 import angle_deg, length_m

MIN_CORRECTION_M, MIN_CORRECTION_DEG = 0.002, 0.1  # smaller ones are below what the map's voxels resolve


@dataclass
class LocatedFrame:
    """A frame in front of a keyframe, and the pose last reported for it."""

    keyframe: int
    keyframe_from_camera: Float64Array
    reported: Pose | None


class LocatedFrames:
    """Frames that follow the keyframes of a map, by frame index."""

    def __init__(self, keyframe_map: KeyframeMap) -> None:
        self._map = keyframe_map
        self._frames: dict[int, LocatedFrame] = {}
        self._frames_of: dict[int, set[int]] = defaultdict(set)  # by keyframe
        self._unchecked: set[int] = set()  # frames that came since `corrections`
        self._checked: dict[int, tuple[int, Float64Array]] = {}  # submap and pose that keyframes had in `corrections`
        self._version = 0  # that the map had

    def add(self, index: int, reference: Keyframe, reference_from_camera: Float64Array) -> Pose | None:
        """Take in a frame; returns its world_from_camera, None in an unanchored submap."""
        located = LocatedFrame(reference.number, reference_from_camera, None)
        located.reported = self._pose(located)
        self._frames[index] = located
        self._frames_of[reference.number].add(index)
        self._unchecked.add(index)
        return located.reported

    def move(self, index: int, keyframe_from_camera: Float64Array) -> None:
        """Let a frame that was taken in lie elsewhere in front of its keyframe."""
        self._frames[index].keyframe_from_camera = keyframe_from_camera
        self._unchecked.add(index)

    def _pose(self, located: LocatedFrame) -> Pose | None:
        if self._map.keyframes[located.keyframe].submap:
            return None
        return self._map.pose(located.keyframe, located.keyframe_from_camera)

    def reported(self, index: int) -> Pose | None:
        """The pose last reported for a frame, None for one that is not located."""
        located = self._frames.get(index)
        return None if located is None else located.reported

    def trajectory(self) -> dict[int, Pose]:
        """world_from_camera of every frame of the world, as known now."""
        poses = ((index, self._pose(located)) for index, located in self._frames.items())
        return {index: pose for index, pose in poses if pose is not None}

    def submaps(self) -> Counter[int]:
        """How many frames each submap shows."""
        return Counter(self._map.keyframes[located.keyframe].submap for located in self._frames.values())

    def corrections(self) -> dict[int, Pose | None]:
        """Poses that differ from those reported last, those never reported, and None for those reported in a submap
        that is not the world any more."""
        if self._version == self._map.version:
            return {}
        self._version = self._map.version
        changed: dict[int, Pose | None] = {}
        for index in sorted(self._stale()):
            located = self._frames[index]
            pose = self._pose(located)
            if pose is None and located.reported is None:
                continue
            if pose is None or located.reported is None or _has_moved(located.reported, pose):
                changed[index] = located.reported = pose
        return changed

    def _stale(self) -> set[int]:
        """Frames whose pose may be another than when they were last looked at."""
        stale, self._unchecked = self._unchecked, set()
        for keyframe in self._map.keyframes.all:
            submap, pose = self._checked.get(keyframe.number, (-1, keyframe.world_from_camera))
            if submap != keyframe.submap or not np.array_equal(pose, keyframe.world_from_camera):
                self._checked[keyframe.number] = keyframe.submap, keyframe.world_from_camera.copy()
                stale |= self._frames_of[keyframe.number]
        return stale


def _has_moved(reported: Pose, pose: Pose) -> bool:
    offset = inverse(reported) @ pose
    return length_m(offset) > MIN_CORRECTION_M or angle_deg(offset) > MIN_CORRECTION_DEG
