"""TUM trajectories, matched with frames by their stamps.

A program that wrote a pose for each image stamped it with that image: the pose is the frame's whose stamp is nearest.
One that wrote at a rate of its own, as motion capture does, is asked for the time between two of its poses: it is told
by gaps of another length, or by stamps that lie now before, now after those of frames.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np

from data_tools.recordings.trajectories import InterpolatedPoses, NearestPoses, PoseSource, Trajectory, read_trajectory
from razer.arrays import Float64Array
from razer.errors import BadInput

SAME_RATE = 1.2  # gaps that differ by a smaller factor are of one rate, whatever frames either left out
SAME_CLOCK = 0.25  # of a gap, by which the distances of nine in ten nearest stamps may differ for poses of images
NOTED = 0.1  # of a gap: nearest stamps that are farther off are said to be
SAME_M, SAME_DEG = 0.01, 1.0  # poses of one stamp that differ by more contradict each other
_UNITS = {"milliseconds": 1e-3, "microseconds": 1e-6, "nanoseconds": 1e-9}
_ANOTHER_UNIT = 20  # factor within which gaps and lengths are those of a recording, by whatever rate poses come
NEAREST, INTERPOLATED = "TUM, nearest stamps", "TUM, interpolated as its rate differs"


def poses_by_time(path: Path, stamps: Float64Array) -> tuple[PoseSource, str]:
    """What a TUM file says of frames at stamps (N,), seconds: their poses, and how they were matched: within half a gap
    between frames, or interpolated where the file has another rate. Raises BadInput where it covers none of them."""
    trajectory = read_trajectory(path)
    times = trajectory.stamps
    finite = stamps[np.isfinite(stamps)]
    if not len(times):
        raise BadInput(f"{path} holds no pose: it needs lines `stamp tx ty tz qx qy qz qw`")
    gap_s = _gap_s(finite)
    if unit := _other_unit(times, finite):
        raise BadInput(f"{path}: its stamps are {unit}, it seems: write seconds")
    if not len(finite) or times[0] > finite.max() + gap_s or times[-1] < finite.min() - gap_s:
        theirs, ours = f"{times[0]:.3f} to {times[-1]:.3f}", f"{stamps[0]:.3f} to {stamps[-1]:.3f}"
        raise BadInput(
            f"{path}: its stamps, {theirs} s, are none of the recording's, {ours} s: write them by the same clock, or "
            "one line of 12 numbers a frame, as KITTI has it"
        )
    _refuse_contradictions(path, trajectory)
    nearest = _nearest_stamps(trajectory, stamps)
    is_near = np.abs(nearest - stamps) <= gap_s / 2
    off_s = (nearest - stamps)[is_near]
    if len(times) > 1 and not (1 / SAME_RATE <= _gap_s(times) / gap_s <= SAME_RATE and _is_steady(off_s, gap_s)):
        return InterpolatedPoses(trajectory, tuple(stamps.tolist())), INTERPOLATED
    usual_s = float(np.median(np.abs(off_s))) if len(off_s) else 0.0
    note = f"{NEAREST}, {usual_s:.3f} s off at the median" if usual_s > NOTED * gap_s else NEAREST
    # Where none is within reach, the frame's own stamp: no pose is found for it then.
    return NearestPoses(trajectory, tuple(np.where(is_near, nearest, stamps).tolist())), note


def _other_unit(times: Float64Array, stamps: Float64Array) -> str | None:
    """The unit in which stamps of poses are those of a recording, if they are in one that is smaller than a second."""
    if min(len(times), len(stamps)) < 2:
        return None
    gap, length = _gap_s(times) / _gap_s(stamps), np.ptp(times) / max(np.ptp(stamps), 1e-6)
    for unit, unit_s in _UNITS.items():
        is_alike = all(1 / _ANOTHER_UNIT < ratio * unit_s < _ANOTHER_UNIT for ratio in (gap, length))
        if is_alike and times[0] * unit_s <= stamps.max() and times[-1] * unit_s >= stamps.min():
            return unit
    return None


def _is_steady(off_s: Float64Array, gap_s: float) -> bool:
    """Whether nearest stamps lie much the same from those of frames: an image's own, whatever clock wrote them."""
    low, high = np.quantile(off_s, (0.05, 0.95)) if len(off_s) else (0.0, 0.0)
    return bool(high - low <= SAME_CLOCK * gap_s)


def _refuse_contradictions(path: Path, trajectory: Trajectory) -> None:
    """Raise BadInput where two poses of one stamp are of different places: nobody knows which one is meant."""
    for n in np.flatnonzero(np.diff(trajectory.stamps) == 0).tolist():
        shift_m = float(np.linalg.norm(trajectory.positions[n + 1] - trajectory.positions[n]))
        one, other = trajectory.quaternions[n : n + 2]
        chord = min(np.linalg.norm(one - other), np.linalg.norm(one + other))  # of half the angle
        if shift_m > SAME_M or chord > 2 * np.sin(np.radians(SAME_DEG) / 4):
            stamp = f"{trajectory.stamps[n]:.6f}"
            raise BadInput(f"{path}: the stamp {stamp} has two poses, {shift_m:.2f} m apart: keep one")


def _gap_s(stamps: Float64Array) -> float:
    """The usual time from one stamp to the next."""
    steps = np.diff(np.sort(stamps))
    return max(float(np.median(steps)), 1e-6) if len(steps) else 1.0


def _nearest_stamps(trajectory: Trajectory, stamps: Float64Array) -> Float64Array:
    """The stamps (N,) of the poses that are nearest to those of frames."""
    after = np.searchsorted(trajectory.stamps, stamps).clip(1, max(len(trajectory.stamps) - 1, 1))
    both = np.stack([trajectory.stamps[after - 1], trajectory.stamps[after.clip(max=len(trajectory.stamps) - 1)]])
    nearest: Float64Array = np.where(np.abs(both[0] - stamps) <= np.abs(both[1] - stamps), both[0], both[1])
    return nearest
