"""TUM trajectories, matched with frames by their stamps.

A program that wrote a pose for each image stamped it with that image: the pose is the frame's whose stamp is nearest.
One that wrote at a rate of its own, as motion capture does, is asked for the time between two of its poses.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np

from data_tools.recordings.trajectories import InterpolatedPoses, NearestPoses, PoseSource, Trajectory, read_trajectory
from razer.arrays import Float64Array
from razer.errors import BadInput

SAME_RATE = 1.2  # gaps that differ by a smaller factor are of one rate, whatever frames either left out
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
    if not len(finite) or times[0] > finite.max() + gap_s or times[-1] < finite.min() - gap_s:
        theirs, ours = f"{times[0]:.3f} to {times[-1]:.3f}", f"{stamps[0]:.3f} to {stamps[-1]:.3f}"
        raise BadInput(
            f"{path}: its stamps, {theirs} s, are none of the recording's, {ours} s: write them by the same clock, or "
            "one line of 12 numbers a frame, as KITTI has it"
        )
    if len(times) > 1 and not 1 / SAME_RATE <= _gap_s(times) / gap_s <= SAME_RATE:
        return InterpolatedPoses(trajectory, tuple(stamps.tolist())), INTERPOLATED
    return NearestPoses(trajectory, _nearest_stamps(trajectory, stamps, gap_s / 2)), NEAREST


def _gap_s(stamps: Float64Array) -> float:
    """The usual time from one stamp to the next."""
    steps = np.diff(np.sort(stamps))
    return max(float(np.median(steps)), 1e-6) if len(steps) else 1.0


def _nearest_stamps(trajectory: Trajectory, stamps: Float64Array, reach_s: float) -> tuple[float, ...]:
    """The stamp of the pose that is nearest to each frame, the frame's own where none is within reach: there no pose is
    found then."""
    after = np.searchsorted(trajectory.stamps, stamps).clip(1, max(len(trajectory.stamps) - 1, 1))
    both = np.stack([trajectory.stamps[after - 1], trajectory.stamps[after.clip(max=len(trajectory.stamps) - 1)]])
    nearest = np.where(np.abs(both[0] - stamps) <= np.abs(both[1] - stamps), both[0], both[1])
    found: list[float] = np.where(np.abs(nearest - stamps) <= reach_s, nearest, stamps).tolist()
    return tuple(found)
