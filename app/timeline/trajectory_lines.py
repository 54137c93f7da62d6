"""A camera trajectory as polylines, broken where the camera was lost, drawn anew only when it was corrected."""

from __future__ import annotations

from collections.abc import Mapping
from itertools import groupby

import numpy as np

from razer.arrays import Float64Array, Pose
from razer.geometry import transform_points


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
