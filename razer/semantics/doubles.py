"""Doubles: instances of one class whose surfaces overlap or continue each other are pieces of one thing."""

from __future__ import annotations

import numpy as np

from razer.semantics.upright_instance import UprightInstance

_ABUT_M = 0.04
_OVERLAP = 0.3  # share of the smaller that lies on the larger
_CONTINUES = 0.35  # share of the border across which the surface goes on
_PARALLEL, _STEP_M = 0.9, 0.012
_MIN_BORDER = 3


def is_double(one: UprightInstance, other: UprightInstance) -> bool:
    """Whether two instances of one class are the same thing: much of the smaller lies on the larger, or the surface
    goes on smoothly across most of their border, without the edge or the step that two things leave."""
    if not one.name or one.name != other.name or one.stuff or other.stuff:
        return False
    small, large = sorted((one, other), key=lambda instance: len(instance.points))
    distances, rows = large.tree.query(small.points, distance_upper_bound=_ABUT_M)
    touching = np.isfinite(distances)
    if touching.mean() >= _OVERLAP:
        return True
    rows, normals = rows[touching], small.normals[touching]
    if len(rows) < _MIN_BORDER:
        return False
    offset = np.abs(np.einsum("nk,nk->n", large.points[rows] - small.points[touching], normals))
    parallel = np.einsum("nk,nk->n", large.normals[rows], normals) > _PARALLEL
    return bool((parallel & (offset <= _STEP_M)).mean() >= _CONTINUES)
