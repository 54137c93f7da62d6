"""Unit weight of a pose graph (a posteriori variance of unit weight, adjustment calculus): by how many of the sigmas that
edges count with they differ from what follows from all of them, and with it covariances that are as large as errors."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from razer.arrays import Float64Array
from slam.backend.pose_graph import PoseEdge, PoseGraph, edge_pull, mahalanobis

HALF_OF_SIX = 5.348  # half of all sums of six squared normal deviations are less
# What few redundant edges say of the unit weight counts as much as that many which say it is the usual one. That is one
# of real recordings; simulated ones have 0.02 to 0.05, so who knows little promises too little.
USUAL, USUAL_COUNTS = 0.1, 10
# Registrations of one camera err together, which their inconsistency does not show, and their errors do not average out:
# poses differ from the truth by this many times as much as if each erred by itself. Measured, see docs/method.md.
POSES_IN_COMMON = 4.0
GROWTH = 1.1  # by which edges must have become more for the unit weight to be measured anew


def unit_weight(edges: Sequence[PoseEdge], poses: Mapping[int, Float64Array]) -> float | None:
    """By how many of their sigmas edges err, each by itself, from the median of how far they differ from the poses
    (4, 4) that follow from all; None where none is redundant."""
    n_redundant = len(edges) - (len(poses) - 1)
    if n_redundant < 1:
        return None
    squared = float(np.median([mahalanobis(edge, poses) ** 2 for edge in edges]))
    return float(np.sqrt(squared / HALF_OF_SIX * len(edges) / n_redundant))


@dataclass
class CovarianceScale:
    """By how many of the sigmas that its edges count with the poses of a graph are off. It is measured anew as edges
    become more, and while there are few loops stays near USUAL, which is on the safe side."""

    unit: float = USUAL * POSES_IN_COMMON
    n_edges: int = 0  # that it was measured from

    def measured(self, graph: PoseGraph) -> float:
        """The unit of a graph as it is now, or was a few edges before."""
        if len(graph.edges) > GROWTH * self.n_edges:
            self.measure(graph)
        return self.unit

    def measure(self, graph: PoseGraph) -> None:
        """Measure it from all edges."""
        n_redundant = max(len(graph.edges) - (len(graph.poses) - 1), 0)
        found = unit_weight(graph.edges, graph.poses) or USUAL
        logarithms, counts = np.log([max(found, 1e-6), USUAL]), (n_redundant, USUAL_COUNTS)
        self.unit = POSES_IN_COMMON * float(np.exp(np.average(logarithms, weights=counts)))
        self.n_edges = len(graph.edges)


def calibrated(edges: Iterable[PoseEdge], poses: Mapping[int, Float64Array], unit: float) -> list[PoseEdge]:
    """The edges with the information that they truly have: less what is noise, which leaves directions open that are,
    as much as they still pull against others that contradict them, and by their unit.

    Args:
        edges: motions that were measured between keyframes.
        poses: the poses (4, 4) that follow from these.
        unit: how many of the sigmas that they count with they are off.
    """
    return [_calibrated(edge, edge_pull(edge, poses) / unit**2) for edge in edges]


def _calibrated(edge: PoseEdge, times: float) -> PoseEdge:
    noise = np.zeros((6, 6)) if edge.noise_information is None else edge.noise_information
    return replace(edge, information=times * (edge.information - noise), noise_information=None)
