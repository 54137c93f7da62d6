"""Coplanarity of regions, from plane moments that add up when regions merge."""

from __future__ import annotations

import numpy as np

from razer.arrays import Float32Array, Float64Array, Int64Array

N_SUMS = 10
_ROW, _COLUMN = np.triu_indices(4)  # the ten different entries of a symmetric 4x4 matrix


def plane_sums(inverse: Float32Array, u: Float32Array, v: Float32Array) -> Float32Array:
    """The N_SUMS products (N_SUMS, h, w) of (1, u, v, inverse depth) with themselves, to be summed up."""
    ones = np.ones_like(inverse)
    terms = (ones, u * ones, v * ones, inverse)
    return np.stack([terms[row] * terms[column] for row, column in zip(_ROW, _COLUMN, strict=True)])


def plane_misfit(sums: Float64Array, pairs: Int64Array) -> Float64Array:
    """Root mean square distance (E,), in inverse depth, 1/m, of the smaller of each pair's regions from the
    plane through the larger; infinite where the larger does not determine a plane."""
    moments = np.zeros((len(sums), 4, 4))
    moments[:, _ROW, _COLUMN] = moments[:, _COLUMN, _ROW] = sums
    first_larger = sums[pairs[:, 0], 0] >= sums[pairs[:, 1], 0]
    larger = np.where(first_larger, pairs[:, 0], pairs[:, 1])
    smaller = np.where(first_larger, pairs[:, 1], pairs[:, 0])
    hosts, index = np.unique(larger, return_inverse=True)
    is_determined = np.linalg.det(moments[hosts, :3, :3]) > 1e-6 * np.maximum(sums[hosts, 0], 1) ** 3
    normal_equations = np.where(is_determined[:, None, None], moments[hosts, :3, :3], np.eye(3))
    planes = np.concatenate(
        [np.linalg.solve(normal_equations, moments[hosts, :3, 3:])[..., 0], np.full((len(hosts), 1), -1.0)], axis=1
    )[index]
    squares = np.einsum("ei,eij,ej->e", planes, moments[smaller], planes) / np.maximum(sums[smaller, 0], 1)
    return np.where(is_determined[index], np.sqrt(np.maximum(squares, 0)), np.inf)
