"""Camera path of a run, as the page plays it."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
from scipy.spatial.transform import Rotation

from app.run_folder.run_folder import TRAJECTORY
from data_tools.recordings.trajectories import read_trajectory
from razer.arrays import Float64Array
from razer.errors import BadInput

MAX_POSES = 1500


def camera_path(run: Path, world_from_run: Float64Array | None = None) -> dict[str, Any] | None:
    """{stamps_s (N,), positions_m (N, 3), quaternions (N, 4) x y z w}, world from camera, at most MAX_POSES of them
    spread evenly; None where a run has no trajectory that can be read.

    Args:
        run: the folder of the run.
        world_from_run: (4, 4) brings the poses into another frame.
    """
    path = run / TRAJECTORY
    if not path.is_file():
        return None
    try:
        trajectory = read_trajectory(path)
        poses = trajectory.matrices()
    except (BadInput, ValueError):
        return None
    if not len(poses):
        return None
    poses = poses if world_from_run is None else world_from_run @ poses
    rows = np.unique(np.linspace(0, len(poses) - 1, min(MAX_POSES, len(poses))).round().astype(np.int64))
    quaternions = Rotation.from_matrix(poses[rows, :3, :3]).as_quat(canonical=True)
    return {
        "stamps_s": (trajectory.stamps[rows] - trajectory.stamps[0]).round(3).tolist(),
        "positions_m": poses[rows, :3, 3].round(4).tolist(),
        "quaternions": quaternions.round(5).tolist(),
    }
