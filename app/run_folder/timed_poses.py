"""TUM trajectory files as the evaluator takes them, with what a run says of its frames."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from app.frames.frame_account import FrameAccount
from app.run_folder import run_folder as names
from data_tools.recordings.trajectories import Trajectory, read_trajectory
from razer.errors import BadInput
from razer.files import MALFORMED, read_json
from razer.metrics.scene_pair import TimedPoses


def timed_poses(path: Path) -> TimedPoses:
    """The poses of a TUM file; those at one and the same time count once. Raises BadInput, also for none at all."""
    return _timed(_poses_of(path))


def run_poses(folder: Path) -> tuple[TimedPoses, FrameAccount] | None:
    """The trajectory of a run and the account of its frames; None for a saved map, which has neither. Raises
    BadInput."""
    path = folder / names.TRAJECTORY
    if not path.is_file():
        return None
    trajectory = _poses_of(path)
    account = read_account(folder, len(trajectory.stamps))
    tracked = float("nan") if account.tracked is None else account.tracked
    return replace(_timed(trajectory), tracked=tracked), account


def read_account(folder: Path, n_poses: int) -> FrameAccount:
    """What a run folder keeps of its frames, or what follows from its `n_poses` poses and its timings."""
    try:
        timings = read_json(folder / names.TIMINGS, only_finite=False)
        account = FrameAccount.from_json(timings["account"]) if "account" in timings else _derived(timings, n_poses)
    except MALFORMED:
        return FrameAccount(n_poses)
    return account if account.used == n_poses else FrameAccount(n_poses, account.asked, account.frames)


def _derived(timings: dict[str, Any], n_poses: int) -> FrameAccount:
    """The account of a run before runs kept one. Those that estimated poses ("rebuilding") counted frames twice that
    came late: their number says something only where there were none."""
    frames = int(timings["frames"])
    if frames == n_poses:
        return FrameAccount(n_poses, None, frames, (), 0, ())
    return FrameAccount(n_poses, None, frames if frames > n_poses and "rebuilding" not in timings else None)


def _poses_of(path: Path) -> Trajectory:
    trajectory = read_trajectory(path)
    if not len(trajectory.stamps):
        raise BadInput(f"{path} holds no pose")
    return trajectory


def _timed(trajectory: Trajectory) -> TimedPoses:
    stamps, first = np.unique(trajectory.stamps, return_index=True)
    return TimedPoses(stamps, np.stack([trajectory.nearest(float(s))[0] for s in trajectory.stamps[first]]))
