"""What refinement corrected of given poses, as a run says it and its folder keeps it."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

import numpy as np
from scipy.spatial.transform import Rotation

from app.run_folder.run_folder import GIVEN_TRAJECTORY, TRAJECTORY
from app.run_folder.timed_poses import timed_poses
from razer.arrays import FloatArray, Pose
from razer.metrics.trajectory_errors import match_timestamps

SAME_TIME_S = 1e-4  # of stamps that were written by one run


@dataclass(frozen=True)
class PoseCorrections:
    """By how much `frames` poses were moved and turned in their own world: metres and degrees."""

    frames: int
    median_m: float
    max_m: float
    median_deg: float
    max_deg: float

    @classmethod
    def of(cls, given: Mapping[int, Pose], refined: Mapping[int, Pose]) -> PoseCorrections | None:
        """Between poses (4, 4) of the same frames; None where no frame has both."""
        both = [index for index in refined if index in given]
        return cls.between(*(np.array([poses[index] for index in both]) for poses in (given, refined)))

    @classmethod
    def between(cls, given: FloatArray, refined: FloatArray) -> PoseCorrections | None:
        """Between poses (N, 4, 4) of the same frames; None for none."""
        if not len(given):
            return None
        moved_m = np.linalg.norm(refined[:, :3, 3] - given[:, :3, 3], axis=1)
        turns = Rotation.from_matrix(given[:, :3, :3]).inv() * Rotation.from_matrix(refined[:, :3, :3])
        turned_deg = np.degrees(turns.magnitude())
        figures = (float(of(values)) for values in (moved_m, turned_deg) for of in (np.median, np.max))
        return cls(len(given), *figures)

    def as_json(self) -> dict[str, Any]:
        """Plain values, metres and degrees."""
        return asdict(self)

    def describe(self) -> str:
        """The same in one line."""
        return (
            f"given poses were corrected by {100 * self.median_m:.1f} cm and {self.median_deg:.2f}° (median), "
            f"{100 * self.max_m:.1f} cm and {self.max_deg:.2f}° at most"
        )


def read_corrections(folder: Path) -> PoseCorrections | None:
    """What a run corrected, None for one that refined nothing; raises BadInput."""
    if not (folder / GIVEN_TRAJECTORY).is_file() or not (folder / TRAJECTORY).is_file():
        return None
    given, refined = (timed_poses(folder / name) for name in (GIVEN_TRAJECTORY, TRAJECTORY))
    rows = match_timestamps(given.stamps, refined.stamps, SAME_TIME_S)
    return PoseCorrections.between(given.world_from_camera[rows[0]], refined.world_from_camera[rows[1]])
