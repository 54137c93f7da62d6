"""The way of a camera as lines, broken where it was lost, drawn anew only when it moved."""

from __future__ import annotations

from collections.abc import Mapping
from itertools import groupby

import numpy as np

from razer.arrays import Float64Array
from razer.geometry import transform_points


class PathLines:
    """Poses, world_from_camera (4, 4), by frame index, among all frames looked at."""

    def __init__(self) -> None:
        self.poses: dict[int, Float64Array] = {}
        self._looked_at: list[int] = []
        self._drawn = 0

    def look(self, index: int, pose: Float64Array | None) -> None:
        """A further frame, and where its camera was, if that is known."""
        self._looked_at.append(index)
        if pose is not None:
            self.poses[index] = pose

    def move(self, corrections: Mapping[int, Float64Array | None]) -> None:
        """New poses of frames looked at before, None where one is not known after all."""
        moved = {**self.poses, **corrections}
        self.poses = {index: pose for index, pose in moved.items() if pose is not None}

    def whole(self, world_from_path: Float64Array) -> list[Float64Array]:
        """All of it in another world, a line of camera positions (N, 3) for each stretch without a gap."""
        self._drawn = len(self._looked_at)
        return self._lines(self._looked_at, world_from_path)

    def newest(self, world_from_path: Float64Array) -> list[Float64Array]:
        """What was added since the whole was last drawn, from where that ended."""
        return self._lines(self._looked_at[max(self._drawn - 1, 0) :], world_from_path)

    def _lines(self, indices: list[int], world_from_path: Float64Array) -> list[Float64Array]:
        stretches = (list(run) for known, run in groupby(indices, self.poses.__contains__) if known)
        positions = (np.array([self.poses[index][:3, 3] for index in run]) for run in stretches)
        return [transform_points(world_from_path, line) for line in positions if len(line) > 1]
