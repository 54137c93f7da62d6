"""Known view: the share of what a camera sees that it saw before, by true poses and depth."""

from __future__ import annotations

import numpy as np

from razer.arrays import Float64Array, Int64Array, Pose
from razer.frame import Frame
from razer.geometry import back_project, transform_points

CELL_M = 0.1  # of space; readings of a reduced image lie nearer to each other than that, up to 6 m
PIXELS_ACROSS = 80
_HALF = 2**20  # cells from the origin that a key has room for, along each axis


class KnownCells:
    """Cells of space in which surface was seen."""

    def __init__(self) -> None:
        self._seen: set[int] = set()

    def add(self, cells: Int64Array) -> None:
        """Take in cells (N,) that were seen."""
        self._seen.update(cells.tolist())

    def share(self, cells: Int64Array) -> float:
        """How many of the cells (N,), 0..1, were seen before; 0 without any."""
        return sum(cell in self._seen for cell in cells.tolist()) / max(len(cells), 1)


def seen_cells(frame: Frame, world_from_camera: Pose) -> Int64Array:
    """Keys (N,) of the cells, each once, that the readings of a frame fall into, of an image reduced to some
    PIXELS_ACROSS pixels."""
    step = max(1, frame.intrinsics.width // PIXELS_ACROSS)
    depth = frame.depth[::step, ::step]
    v, u = np.nonzero(depth)
    points = back_project(step * u, step * v, depth[v, u], frame.intrinsics.matrix)
    return np.unique(_keys(transform_points(world_from_camera, points)))


def _keys(points: Float64Array) -> Int64Array:
    x, y, z = (np.floor(points / CELL_M).astype(np.int64) + _HALF).T
    return (x * 2 * _HALF + y) * 2 * _HALF + z
