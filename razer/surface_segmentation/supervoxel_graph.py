"""Region adjacency graph of supervoxels, with what tells a border between things from one within a thing: concave
creases (LCCP, Stein 2014); colours are those of the pieces."""

from __future__ import annotations

import numpy as np

from razer.arrays import BoolArray, Float64Array, Int64Array
from razer.models.geometric.region_graph import RegionGraph, summed_pairs
from razer.surface_segmentation.supervoxels import areas_m2, borders
from razer.surface_segmentation.surface import Surface, unit

# Columns of RegionGraph.sums: square metres, and what is weighted by them; and of RegionGraph.boundary: edges of the
# mesh, and what is summed over them.
AREA, SQUARE = 0, 7
LAB, POSITION = slice(1, 4), slice(4, 7)
LENGTH, CONCAVE_DEG = range(2)


def supervoxel_means(values: Float64Array, supervoxel: Int64Array, n: int) -> Float64Array:
    """Mean (N, C) of values (V, C) over each supervoxel, which every vertex names, -1 for none."""
    is_in = supervoxel >= 0
    counts = np.maximum(np.bincount(supervoxel[is_in], minlength=n), 1)
    sums = [np.bincount(supervoxel[is_in], column[is_in], n) for column in values.T]
    return np.stack(sums, axis=1) / counts[:, None]


def supervoxel_graph(
    surface: Surface, supervoxel: Int64Array, colors: Float64Array, is_thing: BoolArray
) -> RegionGraph:
    """The graph of those of N supervoxels that are no structure.

    Args:
        surface: the surface.
        supervoxel: (V,) of each vertex, -1 for none.
        colors: (N, 3) mean Lab colours.
        is_thing: (N,) which are in the graph; the others have no area and no border.
    """
    n = len(colors)
    normals = unit(supervoxel_means(surface.normals, supervoxel, n))
    middles = supervoxel_means(surface.positions, supervoxel, n)
    ends = borders(surface, supervoxel)
    a, b = ends[is_thing[ends].all(axis=1)].T
    bend = np.degrees(np.arccos(np.clip((normals[a] * normals[b]).sum(axis=1), -1, 1)))
    opens = ((normals[b] - normals[a]) * (middles[b] - middles[a])).sum(axis=1) < 0
    creases = np.stack([np.ones(len(a)), np.where(opens, bend, 0)], axis=1)
    areas = areas_m2(surface, supervoxel, n) * is_thing
    squares = supervoxel_means((surface.positions**2).sum(axis=1, keepdims=True), supervoxel, n)
    sums = areas[:, None] * np.concatenate([np.ones((n, 1)), colors, middles, squares], axis=1)
    return RegionGraph(sums, *summed_pairs(np.stack([a, b], axis=1), creases, n), np.arange(n))


def size_m(sums: Float64Array) -> Float64Array:
    """Length (N,) of the straight rod with the same scatter as each row's surface: about the diagonal, metres."""
    area = np.maximum(sums[:, [AREA]], 1e-12)
    spread = sums[:, [SQUARE]] / area - ((sums[:, POSITION] / area) ** 2).sum(axis=1, keepdims=True)
    return np.sqrt(12 * np.maximum(spread[:, 0], 0))


def mean_colors(sums: Float64Array) -> Float64Array:
    """Mean Lab colour (N, 3) of each row."""
    return sums[:, LAB] / np.maximum(sums[:, [AREA]], 1e-12)
