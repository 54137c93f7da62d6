"""A camera trajectory as polylines, broken where the camera was lost, drawn anew only when it was corrected."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from itertools import groupby

import numpy as np

from razer.arrays import Float64Array, Pose
from razer.geometry import transform_points

DASH_M = 0.04


class TrajectoryLines:
    """Poses, world_from_camera (4, 4), by frame index, among all frames that came."""

    def __init__(self) -> None:
        self.poses: dict[int, Pose] = {}
        self._indices: list[int] = []
        self._n_drawn = 0

    def add(self, index: int, pose: Pose | None) -> None:
        """A further frame, and where its camera was, if that is known."""
        self._indices.append(index)
        if pose is not None:
            self.poses[index] = pose

    def correct(self, corrections: Mapping[int, Pose | None]) -> None:
        """New poses of frames added before, None where one is not known after all."""
        corrected = {**self.poses, **corrections}
        self.poses = {index: pose for index, pose in corrected.items() if pose is not None}

    def whole(self, world_from_trajectory: Float64Array) -> list[Float64Array]:
        """All of it in another world, a line of camera positions (N, 3) for each stretch without a gap."""
        self._n_drawn = len(self._indices)
        return self._lines(self._indices, world_from_trajectory)

    def newest(self, world_from_trajectory: Float64Array) -> list[Float64Array]:
        """What was added since the whole was last drawn, from where that ended."""
        return self._lines(self._indices[max(self._n_drawn - 1, 0) :], world_from_trajectory)

    def _lines(self, indices: list[int], world_from_trajectory: Float64Array) -> list[Float64Array]:
        stretches = (list(run) for known, run in groupby(indices, self.poses.__contains__) if known)
        positions = (np.array([self.poses[index][:3, 3] for index in run]) for run in stretches)
        return [transform_points(world_from_trajectory, line) for line in positions if len(line) > 1]


def dashed(lines: Iterable[Float64Array], dash_m: float = DASH_M) -> list[Float64Array]:
    """Lines of positions (N, 3) as dashes as long as the gaps between them, metres."""
    dashes = []
    for line in lines:
        along_m = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(line, axis=0), axis=1))])
        starts = np.arange(0.0, along_m[-1], 2 * dash_m)
        for start_m in starts:
            inside = (along_m > start_m) & (along_m < start_m + dash_m)
            stops_m = np.concatenate([[start_m], along_m[inside], [min(start_m + dash_m, along_m[-1])]])
            dashes.append(np.stack([np.interp(stops_m, along_m, line[:, axis]) for axis in range(3)], axis=1))
    return dashes
