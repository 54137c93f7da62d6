"""Located frames: each in front of a keyframe, with the pose last reported for it; only those are looked at again whose
keyframe moved so far that one of them may have to be corrected."""

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
        self._checked = np.zeros((0, 4, 4))  # poses that keyframes had when `corrections` looked at their frames
        self._submaps = np.zeros(0, np.int64)  # that they belonged to then
        # How far keyframes may turn (radians) and shift (metres) from there before a frame needs a correction, and how
        # far their frames are from them (metres), which is the lever by which a turn shifts these.
        self._slack_rad, self._slack_m, self._lever_m = np.zeros(0), np.zeros(0), np.zeros(0)
        self._version = 0  # that the map had
        self._has_late = False  # whether frames came since that were not reported when they did

    def add(self, index: int, reference: Keyframe, reference_from_camera: Float64Array) -> Pose | None:
        """Take in a frame; returns its world_from_camera, None in an unanchored submap."""
        located = LocatedFrame(reference.number, reference_from_camera, None)
        located.reported = self._pose(located)
        self._frames[index] = located
        self._frames_of[reference.number].add(index)
        self._unchecked.add(index)
        return located.reported

    def add_late(self, index: int, reference: Keyframe, reference_from_camera: Float64Array) -> None:
        """Take in a frame of which nothing was known when it came: `corrections` has its pose."""
        self.add(index, reference, reference_from_camera)
        self._frames[index].reported = None
        self._has_late = True

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
        """world_from_camera of every frame of the world, as known now, the earliest frame first."""
        poses = ((index, self._pose(self._frames[index])) for index in sorted(self._frames))
        return {index: pose for index, pose in poses if pose is not None}

    def submaps(self) -> Counter[int]:
        """How many frames each submap shows."""
        return Counter(self._map.keyframes[located.keyframe].submap for located in self._frames.values())

    def corrections(self) -> dict[int, Pose | None]:
        """Poses that differ from those reported last, those never reported, and None for those reported in a submap
        that is not the world any more."""
        if self._version == self._map.version and not self._has_late:
            return {}
        self._version, self._has_late = self._map.version, False
        changed: dict[int, Pose | None] = {}
        for keyframe in self._stale():
            for index in self._frames_of[keyframe]:
                located = self._frames[index]
                pose = self._pose(located)
                if self._needs_correction(keyframe, located, pose):
                    changed[index] = located.reported = pose
        return dict(sorted(changed.items()))

    def _stale(self) -> list[int]:
        """Keyframes of which a frame may need a correction, now taken as checked."""
        poses, submaps = self._map.keyframes.poses(), self._map.keyframes.submaps()
        n_checked, fresh = len(self._checked), {self._frames[index].keyframe for index in self._unchecked}
        self._unchecked.clear()
        turn_rad, shift_m = _motions(self._checked, poses[:n_checked])
        moved = (turn_rad > self._slack_rad) | (shift_m + turn_rad * self._lever_m > self._slack_m)
        moved |= submaps[:n_checked] != self._submaps
        stale = sorted({*np.flatnonzero(moved).tolist(), *range(n_checked, len(poses)), *fresh})
        self._grow(len(poses))
        self._checked[stale], self._submaps[stale] = poses[stale], submaps[stale]
        self._slack_rad[stale], self._slack_m[stale] = np.radians(MIN_CORRECTION_DEG), MIN_CORRECTION_M
        self._lever_m[stale] = 0.0
        return stale

    def _grow(self, n_keyframes: int) -> None:
        """Make room for further keyframes."""
        more = n_keyframes - len(self._checked)
        self._checked = np.concatenate([self._checked, np.zeros((more, 4, 4))])
        self._submaps = np.concatenate([self._submaps, np.zeros(more, np.int64)])
        self._slack_rad, self._slack_m, self._lever_m = (
            np.concatenate([values, np.zeros(more)]) for values in (self._slack_rad, self._slack_m, self._lever_m)
        )

    def _needs_correction(self, keyframe: int, located: LocatedFrame, pose: Pose | None) -> bool:
        """Whether a frame that now is at a pose must be reported anew; if not, what slack that leaves its keyframe."""
        self._lever_m[keyframe] = max(self._lever_m[keyframe], length_m(located.keyframe_from_camera))
        if pose is None or located.reported is None:
            return pose is not located.reported
        offset = inverse(located.reported) @ pose
        turn_deg, shift_m = angle_deg(offset), length_m(offset)
        if turn_deg > MIN_CORRECTION_DEG or shift_m > MIN_CORRECTION_M:
            return True
        self._slack_rad[keyframe] = min(self._slack_rad[keyframe], np.radians(MIN_CORRECTION_DEG - turn_deg))
        self._slack_m[keyframe] = min(self._slack_m[keyframe], MIN_CORRECTION_M - shift_m)
        return False


def _motions(before: Float64Array, after: Float64Array) -> tuple[Float64Array, Float64Array]:
    """By how much poses (N, 4, 4) turned (N,), radians and rather too much than too little, and shifted (N,) metres."""
    # The Frobenius norm of the difference of two rotations is 2 sqrt(2) sin(angle / 2), and sin(x) >= 2 x / pi.
    chord = np.linalg.norm(after[:, :3, :3] - before[:, :3, :3], axis=(1, 2)) / np.sqrt(2)
    turn_rad = np.where(chord < 0.1, 1.001 * chord, np.pi / 2 * chord)
    return turn_rad, np.linalg.norm(after[:, :3, 3] - before[:, :3, 3], axis=1)
