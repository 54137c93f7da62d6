"""Uncertainty of the poses of a graph: marginal covariances, as large as errors, by what edges contradict each other.

Edges count by a share of the information of their residuals that is the same for all sensors and places. By how much
that is wrong is measured (a posteriori variance of unit weight); what is left are errors that registrations have in
common, which no contradiction shows: these are a property of the method, and two constants.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, replace

import numpy as np

from razer.arrays import Float64Array
from slam.backend.pose_graph import GEMAN_MCCLURE, PoseGraph, mahalanobis
from slam.pose_edge import EDGE_SHARE, PoseEdge, unit_weight
from slam.report import OpenStretch, PoseUncertainty
from slam.uncertainty.correlated_errors import error_growth

# What few redundant edges say of the unit weight is weighed against that many which say it is the usual one: that of
# real recordings. Simulated ones have 0.02 to 0.05, so who knows little promises too little.
USUAL, USUAL_COUNTS = 0.1, 10
# Registrations err by so many times as much as they contradict each other: those round about share views, and close
# loops that err together. By such a share, times the unit, all shifts err alike: noise that stays at its pixel pulls
# towards no motion. Both were fitted on simulated runs, see docs/method.md.
ERRORS_IN_COMMON, SHIFT_IN_COMMON = 2.2, 0.009
# An open direction is known no better than to a few hundredths, and in all others that much of the decimetres by which
# a camera may have slid along it is open as well: the standard deviation, metres, that an edge has there at least.
BESIDE_OPEN_M = 0.01
NOTHING = 1e-9  # of the information along the best known axis
GROWTH = 1.1  # by which edges must have become more for the unit weight to be measured anew


@dataclass
class CovarianceScale:
    """By how many of the sigmas that edges count with they are off. It is measured anew as edges become more; while
    there are few loops it stays near the usual one, which is on the safe side."""

    unit: float = USUAL * ERRORS_IN_COMMON
    n_edges: int = 0  # that it was measured from

    def of(self, graph: PoseGraph) -> float:
        """That of a graph as it is now, or was a few edges before."""
        return self.measure(graph) if len(graph.edges) > GROWTH * self.n_edges else self.unit

    def measure(self, graph: PoseGraph) -> float:
        """That of a graph as it is now."""
        n_redundant = max(len(graph.edges) - (len(graph.poses) - 1), 0)
        loops = [mahalanobis(edge, graph.poses) for edge in graph.edges if not edge.is_odometry]
        found = unit_weight(loops, len(graph.edges), len(graph.poses))
        logarithms = np.log([max(found or USUAL, 1e-6), USUAL])
        self.unit = ERRORS_IN_COMMON * float(np.exp(np.average(logarithms, weights=(n_redundant, USUAL_COUNTS))))
        self.n_edges = len(graph.edges)
        return self.unit


def final_uncertainty(graph: PoseGraph, unit: float, stretches: tuple[OpenStretch, ...] = ()) -> PoseUncertainty:
    """Of the poses of a finished graph.

    Args:
        graph: over them.
        unit: by how many of the sigmas that edges count with they are off.
        stretches: of frames that leave a direction open.
    """
    edges = calibrated(graph, unit)
    return PoseUncertainty(covariances(graph, edges, unit), local_sigmas_m(edges), stretches)


def covariances(graph: PoseGraph, edges: list[PoseEdge], unit: float) -> dict[int, Float64Array]:
    """The covariances (6, 6) of all keyframes where they can be computed, as PoseGraph has them, from edges that are
    calibrated by their unit."""
    share = SHIFT_IN_COMMON * unit
    longer = [replace(edge, a_from_b=_stretched(edge.a_from_b, 1 + share)) for edge in edges]
    displaced = graph.displacements(edges, longer)
    outer = {n: np.outer(move, move) for n, move in displaced.items()}
    times = error_growth(graph)
    return {n: times[n] * marginal + outer.get(n, 0.0) for n, marginal in graph.covariances(edges).items()}


def live_covariance(graph: PoseGraph, keyframe: int, unit: float) -> Float64Array | None:
    """The covariance (6, 6) of a keyframe while the camera moves on; None where iSAM2 has none."""
    covariance = graph.covariance(keyframe)
    return None if covariance is None else float(error_growth(graph)[keyframe]) * unit**2 * covariance


def _stretched(motion: Float64Array, times: float) -> Float64Array:
    result = motion.copy()
    result[:3, 3] *= times
    return result


def local_sigmas_m(edges: Iterable[PoseEdge]) -> dict[int, float]:
    """How firmly calibrated edges hold each keyframe where its neighbours are: the standard deviation, metres, by which
    they leave open where lies what it sees LEVER_M ahead. It does not grow with the way from where the world begins."""
    firmness: dict[int, float] = {}
    for edge in edges:
        for end in (edge.a, edge.b):
            firmness[end] = firmness.get(end, 0.0) + 1 / edge.variance_m2
    return {keyframe: value**-0.5 for keyframe, value in firmness.items()}


def calibrated(graph: PoseGraph, unit: float) -> list[PoseEdge]:
    """The edges of a graph with the information that they truly have: as much as they still pull against others that
    contradict them, and by their unit."""
    return [_calibrated(edge, _pull(edge, graph) / unit**2) for edge in graph.edges]


def _pull(edge: PoseEdge, graph: PoseGraph) -> float:
    """The share of its information by which an edge still pulls (Geman and McClure); all, if tracking measured it."""
    return 1.0 if edge.is_odometry else (1 + (mahalanobis(edge, graph.poses) / GEMAN_MCCLURE) ** 2) ** -2


def _calibrated(edge: PoseEdge, times: float) -> PoseEdge:
    values, axes = np.linalg.eigh(times * edge.information)
    if values[0] <= NOTHING * values[-1]:
        values = np.minimum(values, 1 / (EDGE_SHARE * BESIDE_OPEN_M**2))
    return replace(edge, information=axes * values @ axes.T)
