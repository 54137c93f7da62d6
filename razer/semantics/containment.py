"""Containment: whether a thing lies below the rim of another, or in a compartment of it, closed on five sides."""

from __future__ import annotations

import numpy as np

from razer.arrays import Float64Array
from razer.semantics.upright_instance import UprightInstance

TOUCH_M = 0.08  # masks are shrunk and surfaces are rounded by the voxels: what touches is this far apart at most
HEADROOM_M = 0.6  # what is over something is at most this far above it
_SECTORS = 24
# Of the directions round a thing: a rim goes all the way round, a compartment is open to one side.
_RIM, _COMPARTMENT = 0.85, 0.5
_COVERED = 0.5
_INWARD = 0.3
_ABOVE_FOOT_M, _RIM_M = 0.03, 0.1


def is_in(source: UprightInstance, target: UprightInstance, supporter: int | None) -> bool:
    """Whether `source` lies in `target`.

    Walls that face it must stand round its lower half: all the way round, or on three sides under a cover if `target`
    also carries it, which makes five. The faces that a label leaks onto are its own and face away from it.

    Args:
        source: what lies there.
        target: what it may lie in.
        supporter: the id of what carries `source`.
    """
    if source.box.volume <= 0 or not target.spans(source.middle, 0.0):
        return False
    around = walls_around(source, target)
    if around >= _RIM:
        return True
    return supporter == target.id and around >= _COMPARTMENT and covered(source, target) >= _COVERED


def walls_around(source: UprightInstance, target: UprightInstance) -> float:
    """In which share of the directions round `source` steep surface of `target` faces it, at the height of its lower
    half."""
    low, _, high = source.heights_m
    top = max((low + high) / 2, low + _RIM_M)
    rows = (target.points[:, 2] >= low + _ABOVE_FOOT_M) & (target.points[:, 2] <= top)
    toward = target.points[rows, :2] - source.middle
    facing = -np.einsum("nk,nk->n", toward, target.normals[rows, :2])
    toward = toward[facing > _INWARD * np.linalg.norm(toward, axis=1)]
    angle = np.arctan2(toward[:, 1], toward[:, 0])
    return len(np.unique(np.floor((angle / (2 * np.pi) + 0.5) * _SECTORS) % _SECTORS)) / _SECTORS


def covered(source: UprightInstance, target: UprightInstance) -> float:
    """The share of `source` that, from above, has surface of `target` over it."""
    over = covering(source, target)
    if len(over) == 0:
        return 0.0
    distances, rows = source.plan.query(over[:, :2], distance_upper_bound=TOUCH_M)
    rows = rows[np.isfinite(distances)]
    cells = np.unique(np.floor(source.sample[:, :2] / TOUCH_M).astype(np.int64), axis=0)
    covered_cells = np.unique(np.floor(source.sample[rows, :2] / TOUCH_M).astype(np.int64), axis=0)
    return len(covered_cells) / len(cells)


def covering(source: UprightInstance, target: UprightInstance) -> Float64Array:
    """The surface (N, 3) of `target` above `source`, and not far above it."""
    _, middle, top = source.heights_m
    low, high = source.bounds[:, :2] + [[-TOUCH_M], [TOUCH_M]]
    inside = ((target.points[:, :2] >= low) & (target.points[:, :2] <= high)).all(axis=1)
    z = target.points[:, 2]
    return target.points[inside & (z > max(middle, top - TOUCH_M)) & (z < top + HEADROOM_M)]
