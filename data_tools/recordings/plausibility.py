"""Plausibility of a recording's stamps and poses: what no camera can have done is told apart before it is mapped."""

from __future__ import annotations

from bisect import bisect_right
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from data_tools.recordings.trajectories import PoseSource
from razer.arrays import BoolArray, Float64Array, IndexArray
from razer.errors import BadInput, UnusableFrame

MAX_DISTANCE_M = 10_000.0  # from the middle of a recording
MAX_SPEED_M_PER_S = 50.0
_MUCH_FASTER = 5.0  # than usual in a recording: at a speed of 30 m/s, not every late stamp is a jump
_FEWEST_POSES = 9  # from which on a recording has a usual speed
_COUNTED_PER_S = 30.0  # of stamps that were made up when a recording was written, and are none


def implausible_frames(
    path: Path, stamps: Float64Array, positions: Float64Array | None, *, recorded_stamps: bool
) -> dict[int, str]:
    """The frames that no camera can have taken, by index, each with the reason.

    Args:
        path: the recording, for messages.
        stamps: (N,) seconds.
        positions: (N, 3) metres, nan where a frame has no usable pose; None = the recording has no poses.
        recorded_stamps: whether stamps are those of a clock, so that they say how fast the camera was.

    Raises:
        BadInput: where no stamp is a number, or the whole recording moves faster than any camera.
    """
    reasons = _odd_stamps(stamps)
    if len(reasons) == len(stamps):
        raise BadInput(f"{path}: no frame has a finite stamp: its stamps must be seconds, one for each frame")
    if positions is None:
        return reasons
    posed = np.asarray(np.isfinite(positions).all(axis=1))
    posed[list(reasons)] = False
    if not posed.any():
        return reasons
    away_m = np.linalg.norm(positions - np.median(positions[posed], axis=0), axis=1)
    for index in np.flatnonzero(posed & (away_m > MAX_DISTANCE_M)).tolist():
        reasons[index] = f"its pose is {away_m[index] / 1000:.0f} km from the others: poses must be metres"
        posed[index] = False
    if recorded_stamps:
        reasons |= _jumps(path, stamps, positions, np.flatnonzero(posed))
    return reasons


def positions_of(pose_of: PoseSource, n_frames: int) -> Float64Array:
    """Where the camera is in each frame, (N, 3) metres; nan where a frame has no usable pose."""
    positions = np.full((n_frames, 3), np.nan)
    for index in range(n_frames):
        try:
            positions[index] = pose_of(index)[0][:3, 3]
        except UnusableFrame:
            continue
    return positions


def _odd_stamps(stamps: Float64Array) -> dict[int, str]:
    """Frames whose stamp is no number, or goes back behind that of a frame before."""
    finite = np.isfinite(stamps)
    reasons = {i: f"its stamp is {stamps[i]}, not a number of seconds" for i in np.flatnonzero(~finite).tolist()}
    rows = np.flatnonzero(finite)
    rising = _longest_rising(stamps[rows])
    for index in rows[~rising].tolist():
        reasons[index] = f"its stamp {stamps[index]:.6f} is out of order: stamps must not go back"
    return reasons


def _longest_rising(values: Float64Array) -> BoolArray:
    """Which values (N,) are of the longest part in which none is below the one before (patience sorting): one that is
    wrong does not make wrong all that come after."""
    ends: list[float] = []  # of the part of each length that ends lowest
    lasts: list[int] = []
    before = np.full(len(values), -1)
    for row, value in enumerate(values.tolist()):
        length = bisect_right(ends, value)
        before[row] = lasts[length - 1] if length else -1
        ends[length : length + 1], lasts[length : length + 1] = [value], [row]
    kept = np.zeros(len(values), np.bool_)
    row = lasts[-1] if lasts else -1
    while row >= 0:
        kept[row] = True
        row = int(before[row])
    return kept


def _jumps(path: Path, stamps: Float64Array, positions: Float64Array, rows: IndexArray) -> dict[int, str]:
    """Frames among `rows` that the camera cannot have reached from those before and after."""
    if len(rows) < _FEWEST_POSES:
        return {}
    steps_s = np.diff(stamps[rows])
    period_s = max(float(np.median(steps_s)), 1e-9)  # stamps come late and in bunches: a step takes at least that
    speeds = np.linalg.norm(np.diff(positions[rows], axis=0), axis=1) / np.maximum(steps_s, period_s)
    usual = float(np.median(speeds))
    if usual > MAX_SPEED_M_PER_S:
        _require_counted(path, stamps[rows], usual)
        return {}
    limit = max(MAX_SPEED_M_PER_S, _MUCH_FASTER * usual)
    first, end = _longest_run(speeds <= limit)
    reach = _Reach(stamps, positions, period_s, limit)
    return reach.missed(rows[end:].tolist()) | reach.missed(rows[: first + 1].tolist()[::-1])


@dataclass(frozen=True)
class _Reach:
    """What a camera of at most `limit` metres a second can have reached, where a frame takes at least `period_s`."""

    stamps: Float64Array
    positions: Float64Array
    period_s: float
    limit: float

    def missed(self, rows: list[int]) -> dict[int, str]:
        """Frames that cannot be reached from the last one before that could, the first of which is sure; with the
        reason. Frames come in order of time, or all against it."""
        reasons, last = {}, rows[0]
        for row in rows[1:]:
            jump_m = float(np.linalg.norm(self.positions[row] - self.positions[last]))
            if jump_m <= self.limit * max(abs(self.stamps[row] - self.stamps[last]), self.period_s):
                last = row
            else:
                reasons[row] = f"its pose is {jump_m:.1f} m from that of frame {last}: no camera moves that fast"
        return reasons


def _require_counted(path: Path, stamps: Float64Array, speed_m_per_s: float) -> None:
    """Refuse poses that always move faster than a camera does, unless stamps are multiples of 1/30 s, as they are made
    up for frames without any."""
    counts = stamps * _COUNTED_PER_S
    if np.abs(counts - np.rint(counts)).max() >= 1e-3:
        raise BadInput(
            f"{path}: by its poses and stamps the camera moves at {speed_m_per_s:.0f} m/s: poses must be metres and "
            "stamps seconds; correct them, or take the poses away for --poses slam"
        )


def _longest_run(steps: BoolArray) -> tuple[int, int]:
    """First and last row of the longest stretch in which each step (N - 1,) to the next row is a good one."""
    edges = np.flatnonzero(~steps)
    starts, ends = np.append(0, edges + 1), np.append(edges, len(steps))
    longest = int((ends - starts).argmax())
    return int(starts[longest]), int(ends[longest])
