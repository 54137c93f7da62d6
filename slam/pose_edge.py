"""Edges of a pose graph: what they measure, how much they count, and how wrong that is."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from razer.arrays import Float64Array
from razer.geometry import inverse
from slam.se3 import adjoint

# Registrations report the information of their residuals as if these were independent and all were right; an edge
# counts by this share of it.
EDGE_SHARE = 0.003
# Bounds along any axis, 1 / rad^2 and 1 / m^2: GTSAM cannot solve for what is all but unknown or all but exact.
INFORMATION = (1.0, 1e7)
OPEN_INFORMATION = 0.01  # the lower bound where covariances are asked for: errors along an open direction all add up
LEVER_M = 2.0  # how far away what a camera sees usually is: there rotation and shift are of one unit
HALF_OF_SIX = 5.348  # half of all sums of six squared normal deviations are less


@dataclass(frozen=True)
class PoseEdge:
    """A measured motion a_from_b (4, 4) between keyframes a < b with the information (6, 6) of a left perturbation
    (rotation, shift); `is_odometry` where tracking led from one to the other, which needs no second opinion."""

    a: int
    b: int
    a_from_b: Float64Array
    information: Float64Array
    is_odometry: bool = False

    @classmethod
    def between(cls, a: int, b: int, a_from_b: Float64Array, information: Float64Array) -> PoseEdge:
        """What was measured between keyframes of any order: where b comes first, as motion b_from_a, whose left
        perturbations are those of a_from_b along b's own axes, turned round."""
        if a < b:
            return cls(a, b, a_from_b, information)
        moved = adjoint(a_from_b)
        return cls(b, a, inverse(a_from_b), moved.T @ information @ moved)

    @cached_property
    def variance_m2(self) -> float:
        """Mean square by which the edge leaves open where what one camera sees, LEVER_M ahead, is for the other."""
        ahead = np.zeros((3, 6))
        ahead[:, 3:] = np.eye(3)
        ahead[0, 1], ahead[1, 0] = LEVER_M, -LEVER_M
        return float(np.trace(ahead @ np.linalg.solve(edge_information(self), ahead.T)))


def offset(world_from_a: Float64Array, world_from_b: Float64Array, a_from_b: Float64Array) -> Float64Array:
    """From where b is to where it was measured in front of a (4, 4), along its own axes."""
    return inverse(inverse(world_from_a) @ world_from_b) @ a_from_b


@dataclass(frozen=True)
class PosePrior:
    """What poses from elsewhere say of keyframe b: that it lies at a_from_b (4, 4) in front of keyframe a, or, where a
    is None, of the world; sigmas (6,), standard deviations along its own axes (rotation, radians; shift, metres), which
    are true ones; unit: by how many of the sigmas that edges count with these are off, so that both can be compared."""

    a: int | None
    b: int
    a_from_b: Float64Array
    sigmas: Float64Array
    unit: float


def edge_information(edge: PoseEdge, least: float = INFORMATION[0]) -> Float64Array:
    """The information (6, 6) that an edge counts by, of a perturbation along b's own axes, at least `least`."""
    moved = adjoint(edge.a_from_b)
    information = EDGE_SHARE * moved.T @ edge.information @ moved
    values, axes = np.linalg.eigh((information + information.T) / 2)
    bounded: Float64Array = axes * values.clip(least, INFORMATION[1]) @ axes.T
    return bounded


def unit_weight(loops: Sequence[float], n_edges: int, n_keyframes: int) -> float | None:
    """By how many of the sigmas they count with edges err, each by itself (unit weight of adjustment calculus), as the
    median of those that close loops says: others may contradict nothing. None where no edge is redundant.

    Args:
        loops: by how many sigmas each edge that closes a loop is off the poses that follow from all edges.
        n_edges: how many edges there are, with those along the way of the camera.
        n_keyframes: how many poses there are, one of them fixed.
    """
    n_redundant = n_edges - (n_keyframes - 1)
    if n_redundant < 1 or not loops:
        return None
    return float(np.sqrt(np.median(np.square(loops)) / HALF_OF_SIX * n_edges / n_redundant))
