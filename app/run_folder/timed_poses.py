"""TUM trajectory files as the evaluator takes them."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from data_tools.recordings.trajectories import read_trajectory
from razer.errors import BadInput
from razer.metrics.scene_pair import TimedPoses


def timed_poses(path: Path) -> TimedPoses:
    """The poses of a TUM file; those at one and the same time count once. Raises BadInput, also for none at all."""
    trajectory = read_trajectory(path)
    if not len(trajectory.stamps):
        raise BadInput(f"{path} holds no pose")
    stamps, first = np.unique(trajectory.stamps, return_index=True)
    return TimedPoses(stamps, np.stack([trajectory.nearest(float(s))[0] for s in trajectory.stamps[first]]))
