"""Geodesic supervoxels: the surface is shared out among seeds on a grid, by ways along the mesh that are the longer
the more they bend and change colour (a geodesic variant of VCCS, Papon 2013)."""

from __future__ import annotations

import numpy as np
from scipy.sparse import coo_matrix
from scipy.sparse.csgraph import dijkstra

from razer.arrays import Float64Array, Int64Array
from razer.surface_segmentation.surface import Surface, color_distance

_PER_DEGREE = 0.1  # how much longer an edge is for each degree between the normals of its ends
_PER_LAB_UNIT = 0.1
_MIN_SEED_VERTICES = 3
_SHORTEST_M = 1e-4


def supervoxels(surface: Surface, size_m: float) -> tuple[Int64Array, int]:
    """The supervoxel (V,) of each vertex, -1 for specks that hold no seed, and how many there are; they are about
    `size_m` wide, and numbered by their places, whatever the order of the vertices."""
    seeds = _seeds(surface.positions, size_m)
    if not len(seeds):
        return np.full(len(surface), -1), 0
    a, b = surface.edges.T
    graph = coo_matrix((_edge_lengths(surface), (a, b)), (len(surface), len(surface))).tocsr()
    source = dijkstra(graph, directed=False, indices=seeds, min_only=True, return_predecessors=True)[2]
    number = np.full(len(surface) + 1, -1)
    number[seeds] = np.arange(len(seeds))
    return number[np.where(source >= 0, source, len(surface))], len(seeds)


def borders(surface: Surface, supervoxel: Int64Array) -> Int64Array:
    """The two supervoxels (B, 2) at each edge of the mesh between two of them; supervoxel (V,), -1 for none."""
    ends = supervoxel[surface.edges]
    return ends[(ends[:, 0] != ends[:, 1]) & (ends >= 0).all(axis=1)]


def areas_m2(surface: Surface, supervoxel: Int64Array, n: int) -> Float64Array:
    """Square metres (N,) of each of n supervoxels."""
    is_in = supervoxel >= 0
    return np.bincount(supervoxel[is_in], surface.areas[is_in], n).astype(np.float64)


def _edge_lengths(surface: Surface) -> Float64Array:
    a, b = surface.edges.T
    length = np.linalg.norm(surface.positions[a] - surface.positions[b], axis=1)
    bend = np.degrees(np.arccos(np.clip((surface.normals[a] * surface.normals[b]).sum(axis=1), -1, 1)))
    change = color_distance(surface.lab[a], surface.lab[b])
    return np.maximum(length, _SHORTEST_M) * (1 + _PER_DEGREE * bend + _PER_LAB_UNIT * change)


def _seeds(positions: Float64Array, size_m: float) -> Int64Array:
    """Of each cube of a grid that holds surface the vertex nearest the middle of it."""
    cubes = np.floor(positions / size_m).astype(np.int64)
    if not len(cubes):
        return np.zeros(0, np.int64)
    cubes -= cubes.min(axis=0)
    _, cube, counts = np.unique(
        np.ravel_multi_index(tuple(cubes.T), tuple(cubes.max(axis=0) + 1)), return_inverse=True, return_counts=True
    )
    middle = np.stack([np.bincount(cube, positions[:, axis]) / counts for axis in range(3)], axis=1)
    apart = np.round(np.linalg.norm(positions - middle[cube], axis=1), 9)
    order = np.lexsort((*positions.T, apart, cube))
    nearest = order[np.flatnonzero(np.diff(cube[order], prepend=-1))]
    return nearest[counts >= _MIN_SEED_VERTICES]
