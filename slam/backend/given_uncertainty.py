"""Uncertainty of given poses, measured: how far registrations contradict them, from one keyframe to the next and where
places are seen again, beyond what registrations contradict each other."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from razer.arrays import Float64Array
from razer.geometry import inverse
from slam.backend.pose_graph import PoseEdge, PosePrior, edge_information, mahalanobis
from slam.refinement_settings import RefinementSettings
from slam.se3 import angle_deg, length_m

# Of what is measured of the given poses half is taken to be right, as registrations may be the ones that err; of these
# nine in ten. As many of three and of six squared normal deviations add up to less than this.
HALF_OF_THREE, NINE_TENTHS_OF_SIX = 2.366, 10.64
FEWEST = 5  # registrations that say something
MIN_WAY_M = 0.1  # that divides the whole one
MIN_SIGMA_M, MIN_SIGMA_DEG = 0.0005, 0.02  # no pose is better than that
# Registrations of one camera err together, which their inconsistency does not show: in simulated rooms they differ from
# the truth by 1.2 to 1.4 times as much as from what follows from all of them.
IN_COMMON = 1.4
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
        steps = _sigmas(given, [edge for edge in edges if edge.is_odometry], unit)
        longest, times = _longest(given, edges)
        drift = _sigmas(given, longest, unit)
        step_m, step_deg = steps or (self.step_m, self.step_deg)
        absolute_m, absolute_deg = (self.absolute_m, self.absolute_deg) if drift is None else times * np.array(drift)
        return GivenUncertainty(
            step_m, step_deg, max(float(absolute_m), step_m), max(float(absolute_deg), step_deg), unit
        )

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
    n_redundant = len(edges) - (len(smoothed) - 1)
    if n_redundant < FEWEST:
        return None
    squared = float(np.quantile([mahalanobis(edge, smoothed) ** 2 for edge in edges], 0.9))
    return IN_COMMON * float(np.sqrt(squared / NINE_TENTHS_OF_SIX * len(edges) / n_redundant))


def _sigmas(given: Poses, edges: Sequence[PoseEdge], unit: float) -> tuple[float, float] | None:
    """Standard deviations along each axis, metres and degrees, by which given motions differ from measured ones beyond
    what is due to these; None for too few edges."""
    if len(edges) < FEWEST:
        return None
    offsets = [inverse(inverse(given[edge.a]) @ given[edge.b]) @ edge.a_from_b for edge in edges]
    squared = np.median([(length_m(o) ** 2, angle_deg(o) ** 2) for o in offsets], axis=0) / HALF_OF_THREE
    covariances = [unit**2 * np.diag(np.linalg.inv(edge_information(edge))) for edge in edges]
    rotation, shift = np.median(covariances, axis=0).reshape(2, 3).mean(axis=1)
    sigma_m, sigma_deg = np.sqrt(np.maximum(squared - (shift, np.degrees(1.0) ** 2 * rotation), 0.0)).tolist()
    return max(sigma_m, MIN_SIGMA_M), max(sigma_deg, MIN_SIGMA_DEG)


def _longest(given: Poses, edges: Sequence[PoseEdge]) -> tuple[list[PoseEdge], float]:
    """The quarter of the edges that span most of the given way, and how many times that of the shortest of them the
    whole way is."""
    numbers = sorted(given)
    steps = [length_m(inverse(given[a]) @ given[b]) for a, b in pairwise(numbers)]
    way_m = dict(zip(numbers, np.cumsum([0.0, *steps]).tolist(), strict=True))
    spans = sorted(((way_m[edge.b] - way_m[edge.a], n) for n, edge in enumerate(edges)), reverse=True)
    kept = spans[: max(len(spans) // 4, FEWEST)]
    return [edges[n] for _, n in kept], way_m[numbers[-1]] / max(kept[-1][0], MIN_WAY_M) if kept else 1.0
