"""Uncertainty of given poses, measured: how far registrations contradict them, from one keyframe to the next and where
places are seen again, beyond what registrations contradict each other."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np

from razer.arrays import Float64Array
from razer.geometry import inverse
from slam.backend.pose_graph import mahalanobis
from slam.pose_edge import PoseEdge, PosePrior, edge_information, offset, unit_weight
from slam.refinement_settings import RefinementSettings
from slam.se3 import angle_deg, length_m

# Of what is measured of the given poses half is taken to be right, as registrations may be the ones that err. Half of
# all sums of three squared normal deviations are less than this.
HALF_OF_THREE = 2.366
FEWEST = 5  # registrations that say something
MIN_WAY_M = 0.1  # that divides the whole one
MIN_SIGMA_M, MIN_SIGMA_DEG = 0.0005, 0.02  # no pose is better than that
# Registrations of one camera err together, which their inconsistency does not show: in four simulated rooms and part of
# an apartment they differ from the truth by 1.3 to 1.8 times as much as from what follows from all of them; and of the
# nine in ten that are right the farthest are off by 1.4 times as much as normal ones whose median is the same.
IN_COMMON = 2.5
USUAL_UNIT = 0.25  # of registrations of real recordings; those of simulated ones have 0.05

Poses = Mapping[int, Float64Array]
"""world_from_camera (4, 4) by keyframe."""


@dataclass(frozen=True)
class GivenUncertainty:
    """Standard deviations along each axis: of a given motion between neighbouring keyframes, and of a given pose in its
    world, metres and degrees. unit: how many of the sigmas that the graph gives them registrations are off by (the unit
    weight of adjustment calculus), as these sigmas are not meant to be true."""

    step_m: float
    step_deg: float
    absolute_m: float
    absolute_deg: float
    unit: float = USUAL_UNIT

    @classmethod
    def of(cls, settings: RefinementSettings) -> GivenUncertainty:
        """What is taken to hold until it is measured."""
        return cls(settings.sigma_m, settings.sigma_deg, settings.absolute_sigma_m, settings.absolute_sigma_deg)

    def measured(self, given: Poses, edges: Sequence[PoseEdge], smoothed: Poses) -> GivenUncertainty:
        """What registrations tell of it; where they are too few, it stays.

        Args:
            given: the given poses.
            edges: motions that were measured between keyframes, and are believed.
            smoothed: the poses that follow from these.
        """
        unit = _unit_weight(edges, smoothed) or self.unit
        span = _Span.of(given, edges)
        step, drift = _sigmas(given, _surest(edges), unit), _sigmas(given, span.edges, unit)
        if step is None or drift is None:
            return replace(self, unit=unit)
        # What grows with the way goes on growing over all of it; what does not is noise.
        growth = np.sqrt(np.maximum(drift**2 - step**2, 0.0))
        absolute = np.hypot(step, growth * span.n_times)
        # A chain of steps that each err by themselves must be able to err as much as was measured over many.
        step = np.maximum(step, drift / np.sqrt(span.n_steps))
        return GivenUncertainty(step[0], step[1], absolute[0], absolute[1], unit)

    def priors(self, given: Poses, number: int, before: int | None) -> list[PosePrior]:
        """What the given poses say of a keyframe: where it lies, and how from the one before.

        Args:
            given: the given poses.
            number: the keyframe.
            before: its neighbour, None for the first.
        """
        priors = [PosePrior(None, number, given[number], _axes(self.absolute_deg, self.absolute_m), self.unit)]
        if before is not None:
            motion = inverse(given[before]) @ given[number]
            priors.append(PosePrior(before, number, motion, self.step_sigmas, self.unit))
        return priors

    @property
    def step_sigmas(self) -> Float64Array:
        """(6,) of a given motion between neighbours: rotation, radians; shift, metres."""
        return _axes(self.step_deg, self.step_m)


def _axes(sigma_deg: float, sigma_m: float) -> Float64Array:
    return np.repeat([np.radians(sigma_deg), sigma_m], 3)


def _unit_weight(edges: Sequence[PoseEdge], smoothed: Poses) -> float | None:
    """By how many of their sigmas edges differ from what follows from all; None where none is redundant."""
    if len(edges) - (len(smoothed) - 1) < FEWEST:
        return None
    loops = [mahalanobis(edge, smoothed) for edge in edges if not edge.is_odometry]
    unit = unit_weight(loops, len(edges), len(smoothed))
    return None if unit is None else IN_COMMON * unit


def _sigmas(given: Poses, edges: Sequence[PoseEdge], unit: float) -> Float64Array | None:
    """Standard deviations along each axis (2,), metres and degrees, by which given motions differ from measured ones
    beyond what is due to these; None for too few edges."""
    if len(edges) < FEWEST:
        return None
    offsets = [offset(given[edge.a], given[edge.b], edge.a_from_b) for edge in edges]
    squared = np.median([(length_m(o) ** 2, angle_deg(o) ** 2) for o in offsets], axis=0) / HALF_OF_THREE
    own = np.median([_variances(edge) for edge in edges], axis=0) * unit**2
    return np.maximum(np.sqrt(np.maximum(squared - own, 0.0)), (MIN_SIGMA_M, MIN_SIGMA_DEG))


def _variances(edge: PoseEdge) -> Float64Array:
    """Mean variances along the axes (2,) that an edge counts with, of shift, m^2, and of rotation, deg^2."""
    rotation, shift = np.diag(np.linalg.inv(edge_information(edge))).reshape(2, 3).mean(axis=1)
    return np.array([shift, np.degrees(1.0) ** 2 * rotation])


def _surest(edges: Sequence[PoseEdge]) -> list[PoseEdge]:
    """The quarter of the edges along the way of the camera that is known best: the others tell little."""
    along = sorted((edge for edge in edges if edge.is_odometry), key=lambda edge: float(_variances(edge)[0]))
    return along[: max(len(along) // 4, FEWEST)]


@dataclass(frozen=True)
class _Span:
    """The quarter of all edges that span most of the given way: how many keyframes the usual one of them does, and how
    many times its way the whole one is."""

    edges: list[PoseEdge]
    n_steps: float
    n_times: float

    @classmethod
    def of(cls, given: Poses, edges: Sequence[PoseEdge]) -> _Span:
        if not edges:
            return cls([], 1.0, 1.0)
        numbers = sorted(given)
        steps = [length_m(inverse(given[a]) @ given[b]) for a, b in pairwise(numbers)]
        way_m = dict(zip(numbers, np.cumsum([0.0, *steps]).tolist(), strict=True))
        longest = sorted(edges, key=lambda edge: way_m[edge.a] - way_m[edge.b])[: max(len(edges) // 4, FEWEST)]
        usual_m = float(np.median([way_m[edge.b] - way_m[edge.a] for edge in longest]))
        n_steps = float(np.median([edge.b - edge.a for edge in longest]))
        return cls(longest, n_steps, max(way_m[numbers[-1]] / max(usual_m, MIN_WAY_M), 1.0))
