"""Merging supervoxels to things: a logistic model of whether two pieces that touch are one, applied greedily; and
another of whether what came of it is a whole thing.

The weights are fitted to four fused maps, two apartments and two walks through holey scans (docs/evaluation.md says how
well they do on others): a few numbers with a meaning each, instead of thresholds.
"""

from __future__ import annotations

import numpy as np

from razer.arrays import Float64Array
from razer.models.geometric.region_graph import RegionGraph
from razer.surface_segmentation.supervoxel_graph import AREA, CONCAVE_DEG, LENGTH, mean_colors, size_m
from razer.surface_segmentation.surface import color_distance

# Log-odds that two pieces are one thing: for each 20 degrees of a concave crease between them, 20 Lab units of
# difference of their mean colours (both up to three times that), and the natural logarithm of the size of both together
# and of the smaller one, in metres: most of what touches beyond the size of furniture are two things.
_BIAS, _CONCAVE, _COLOR, _JOINT, _SMALLER = 4.0, -1.24, -1.97, -0.8, 0.39
_UNIT, _MOST = 20.0, 60.0
_JOINT_OFFSET_M, _SMALLER_OFFSET_M = 0.05, 0.02
# Log-odds that a region is a whole thing: by logarithms of its area (square metres) and size (metres), which say that
# things are compact; by the probability that it should have been merged with a neighbour; by its contrast, in 20 Lab
# units.
_WHOLE_BIAS, _LOG_AREA, _LOG_SIZE, _RIVAL, _CONTRAST = 2.38, 1.96, -1.97, -1.55, 1.18


def merged_things(graph: RegionGraph, least_probability: float) -> RegionGraph:
    """The graph after merging what is one thing with at least this probability, the most probable first."""
    return graph.merged(lambda current: (1 - _probability_same(current)) / (1 - least_probability))


def wholeness(graph: RegionGraph) -> Float64Array:
    """The probability (N,) of each region that it is a whole thing, at an overlap of 0.25 or 0.5 (the mean)."""
    both, n = np.concatenate([graph.pairs[:, 0], graph.pairs[:, 1]]), len(graph.sums)
    rival = np.zeros(n)
    np.maximum.at(rival, both, np.tile(_probability_same(graph), 2))
    length = np.bincount(both, np.tile(graph.boundary[:, LENGTH], 2), n)
    contrast = np.bincount(both, np.tile(_contrast(graph) * graph.boundary[:, LENGTH], 2), n) / np.maximum(length, 1)
    log_area = np.log(np.maximum(graph.sums[:, AREA], 1e-6))
    log_size = np.log(size_m(graph.sums) + _SMALLER_OFFSET_M)
    shape = _LOG_AREA * log_area + _LOG_SIZE * log_size
    return _sigmoid(_WHOLE_BIAS + shape + _RIVAL * rival + _CONTRAST * contrast)


def _probability_same(graph: RegionGraph) -> Float64Array:
    """That the two regions of each pair (E,) are one thing."""
    a, b = graph.pairs.T
    sizes = size_m(graph.sums)
    concave = np.minimum(graph.boundary[:, CONCAVE_DEG] / graph.boundary[:, LENGTH], _MOST) / _UNIT
    joint = np.log(size_m(graph.sums[a] + graph.sums[b]) + _JOINT_OFFSET_M)
    smaller = np.log(np.minimum(sizes[a], sizes[b]) + _SMALLER_OFFSET_M)
    return _sigmoid(_BIAS + _CONCAVE * concave + _COLOR * _contrast(graph) + _JOINT * joint + _SMALLER * smaller)


def _contrast(graph: RegionGraph) -> Float64Array:
    """Difference of mean colour of the regions of each pair (E,), in units of 20 up to three of them."""
    colors = mean_colors(graph.sums)
    return np.minimum(color_distance(colors[graph.pairs[:, 0]], colors[graph.pairs[:, 1]]), _MOST) / _UNIT


def _sigmoid(log_odds: Float64Array) -> Float64Array:
    return 1 / (1 + np.exp(-log_odds))
