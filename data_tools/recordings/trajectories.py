"""Camera poses from 4x4 matrices and TUM trajectories, checked before anything is fused with them."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from scipy.spatial.transform import Rotation, Slerp

from data_tools.recordings.images import short_name
from razer.arrays import Float64Array, Pose
from razer.errors import BadInput, UnusableFrame
from razer.files import MissingFile, read_lines, read_numbers
from razer.geometry import is_rigid, nearest_rotation, rotation_error

MAX_ROTATION_ERROR = 0.01
PROJECTED = "the rotation of its pose is bent: the nearest one is taken"
_ROUNDED_ROTATION = 1e-3  # max|R'R - I| of files with four decimals, 3e-4, and some: nothing to be told of
MAX_GAP_S = 0.11  # longest stretch without ground truth that is bridged; motion capture gives 100 a second
_QUATERNION_TOLERANCE = 0.01  # files round to four decimals or more
_SAME_STAMP_S = 1e-3
_ROUNDING_S = 1e-5  # files round stamps to six decimals

PoseWithNotes = tuple[Float64Array, tuple[str, ...]]
"""A checked world_from_camera (4, 4) and the notes on what had to be repaired."""
PoseSource = Callable[[int], PoseWithNotes]
"""The pose of the i-th frame of a sequence; raises UnusableFrame where it has none."""


def checked_pose(matrix: Float64Array, source: str) -> PoseWithNotes:
    """A usable world_from_camera from a (4, 4) matrix: a rotation with error max |R^T R - I| <= 0.01 is
    replaced by the nearest one and noted; anything worse raises UnusableFrame naming `source`."""
    if matrix.shape != (4, 4):
        raise UnusableFrame(f"{source}: the pose is not a 4x4 matrix")
    if not np.isfinite(matrix).all():
        raise UnusableFrame(f"{source}: the pose is not finite")
    rotation = matrix[:3, :3]
    if not rotation.any():
        raise UnusableFrame(f"{source}: the rotation is zero")
    if np.abs(matrix[3] - (0, 0, 0, 1)).max() > 1e-6:
        raise UnusableFrame(f"{source}: the last row of the pose is not 0 0 0 1")
    error = rotation_error(rotation)
    if error > MAX_ROTATION_ERROR:
        raise UnusableFrame(f"{source}: the rotation is not orthonormal, max|R'R - I| = {error:.3g}")
    if np.linalg.det(rotation) < 0:
        raise UnusableFrame(f"{source}: the rotation is left-handed")
    if is_rigid(matrix):
        return matrix, ()
    repaired = np.eye(4)
    repaired[:3, :3], repaired[:3, 3] = nearest_rotation(rotation), matrix[:3, 3]
    return repaired, (PROJECTED,) if error > _ROUNDED_ROTATION else ()


def read_pose(path: Path) -> PoseWithNotes:
    """The pose in a text file of 16 numbers, row by row; raises UnusableFrame naming the file."""
    try:
        numbers = read_numbers(path, "a 4x4 matrix")
    except MissingFile:
        raise UnusableFrame(f"{short_name(path)} is missing") from None
    except BadInput as error:
        raise UnusableFrame(f"{short_name(path)}: the pose is not a 4x4 matrix") from error
    if numbers.size != 16:
        raise UnusableFrame(f"{short_name(path)}: the pose has {numbers.size} numbers, not 16")
    return checked_pose(numbers.reshape(4, 4), short_name(path))


@dataclass(frozen=True)
class Trajectory:
    """Poses over time: stamps (N,) ascending seconds, positions (N, 3) metres, quaternions (N, 4) x y z w,
    both world_from_camera; source names the file."""

    source: str
    stamps: Float64Array
    positions: Float64Array
    quaternions: Float64Array

    def nearest(self, stamp: float) -> PoseWithNotes:
        """The pose within 1 ms of `stamp`; raises UnusableFrame where there is none."""
        if not len(self.stamps):
            raise UnusableFrame(f"{self.source} holds no pose")
        i = int(np.abs(self.stamps - stamp).argmin())
        if not abs(self.stamps[i] - stamp) <= _SAME_STAMP_S:  # also refuses nan
            raise UnusableFrame(f"{self.source} has no pose at {stamp:.6f}")
        return checked_pose(_matrix(self._rotation(i).as_matrix(), self.positions[i]), self.source)

    def interpolated(self, stamp: float) -> PoseWithNotes:
        """The pose at `stamp` between its neighbours: positions linear, rotations along the shortest arc.
        Raises UnusableFrame outside the trajectory and in gaps longer than MAX_GAP_S."""
        if len(self.stamps) and np.abs(self.stamps - stamp).min() <= _ROUNDING_S:
            return self.nearest(stamp)
        after = int(np.searchsorted(self.stamps, stamp))
        if after in (0, len(self.stamps)):
            raise UnusableFrame(f"{self.source} does not cover {stamp:.6f}")
        before, gap_s = after - 1, self.stamps[after] - self.stamps[after - 1]
        if gap_s > MAX_GAP_S:
            raise UnusableFrame(f"{self.source} has a gap of {gap_s:.2f} s at {stamp:.6f}")
        share = (stamp - self.stamps[before]) / gap_s
        ends = Rotation.concatenate([self._rotation(before), self._rotation(after)])
        position = (1 - share) * self.positions[before] + share * self.positions[after]
        return checked_pose(_matrix(Slerp([0.0, 1.0], ends)(share).as_matrix(), position), self.source)

    def matrices(self) -> Float64Array:
        """Every pose as world_from_camera (N, 4, 4)."""
        poses = np.tile(np.eye(4), (len(self.stamps), 1, 1))
        poses[:, :3, 3], poses[:, :3, :3] = self.positions, Rotation.from_quat(self.quaternions).as_matrix()
        return poses

    def _rotation(self, i: int) -> Rotation:
        norm = float(np.linalg.norm(self.quaternions[i]))
        if not abs(norm - 1) <= _QUATERNION_TOLERANCE:  # also refuses nan
            raise UnusableFrame(f"{self.source}: the quaternion at {self.stamps[i]:.6f} has length {norm:.3g}, not 1")
        return Rotation.from_quat(self.quaternions[i])


def read_trajectory(path: Path) -> Trajectory:
    """A TUM trajectory, lines of `stamp tx ty tz qx qy qz qw`; raises BadInput naming the file. A last line that is
    cut off and lines without a finite stamp are left out: no frame can have their pose."""
    numbered = [(number, line.split()) for number, line in enumerate(read_lines(path), 1)]
    numbered = [(number, words) for number, words in numbered if words and not words[0].startswith("#")]
    if len(numbered) > 1 and len(numbered[-1][1]) < 8:
        numbered.pop()
    try:
        rows = np.array([words for _, words in numbered], dtype=np.float64).reshape(-1, 8)
    except ValueError:
        raise BadInput(_first_misread(path, numbered)) from None
    rows = rows[np.isfinite(rows[:, 0])]
    rows = rows[np.argsort(rows[:, 0], kind="stable")]
    return Trajectory(path.name, rows[:, 0], rows[:, 1:4], rows[:, 4:])


def _first_misread(path: Path, numbered: Sequence[tuple[int, list[str]]]) -> str:
    """What is wrong with the first line that is not eight numbers."""
    for number, words in numbered:
        with suppress(ValueError):
            np.array(words, dtype=np.float64).reshape(8)
            continue
        return f"{path}, line {number}: every line must read `stamp tx ty tz qx qy qz qw`, not '{' '.join(words)[:60]}'"
    raise AssertionError("all lines are eight numbers")


def tum_line(stamp: float, world_from_camera: Pose, *, canonical: bool = False) -> str:
    """The line `stamp tx ty tz qx qy qz qw` of a pose (4, 4): seconds to six digits, metres and quaternion to nine.
    canonical: of the two quaternions of a rotation the one with qw >= 0."""
    quaternion = Rotation.from_matrix(world_from_camera[:3, :3]).as_quat(canonical=canonical)
    return " ".join([f"{stamp:.6f}", *(f"{number:.9f}" for number in (*world_from_camera[:3, 3], *quaternion))])


def tum_text(stamps: Sequence[float], poses: Sequence[Pose]) -> str:
    """A trajectory as TUM lines `stamp tx ty tz qx qy qz qw` (seconds, metres, world from camera)."""
    lines = ["# stamp tx ty tz qx qy qz qw, world from camera"]
    lines += [tum_line(stamp, pose, canonical=True) for stamp, pose in zip(stamps, poses, strict=True)]
    return "\n".join(lines) + "\n"


def _matrix(rotation: Float64Array, position: Float64Array) -> Float64Array:
    matrix = np.eye(4)
    matrix[:3, :3], matrix[:3, 3] = rotation, position
    return matrix


# Sources of poses are plain values and no closures, as a sequence travels to other processes.
@dataclass(frozen=True, slots=True)
class PoseFiles:
    """One file with a 4x4 matrix for each frame."""

    paths: tuple[Path, ...]

    def __call__(self, index: int) -> PoseWithNotes:
        """The pose of a frame; raises UnusableFrame."""
        return read_pose(self.paths[index])


@dataclass(frozen=True, slots=True)
class NearestPoses:
    """The pose of a trajectory with a frame's own stamp."""

    trajectory: Trajectory
    stamps: tuple[float, ...]

    def __call__(self, index: int) -> PoseWithNotes:
        """The pose of a frame; raises UnusableFrame."""
        return self.trajectory.nearest(self.stamps[index])


@dataclass(frozen=True, slots=True)
class InterpolatedPoses:
    """The pose of a trajectory at the time of a frame."""

    trajectory: Trajectory
    stamps: tuple[float, ...]

    def __call__(self, index: int) -> PoseWithNotes:
        """The pose of a frame; raises UnusableFrame."""
        return self.trajectory.interpolated(self.stamps[index])
