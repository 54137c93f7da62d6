"""Rigid transforms and the pinhole camera. A transform `a_from_b` takes coordinates in b to a."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from razer.arrays import Float64Array, FloatArray


def is_rigid(transform: Float64Array, tolerance: float = 1e-6) -> bool:
    """Whether a (4, 4) matrix is finite, with an orthonormal, right-handed rotation and last row 0 0 0 1."""
    if transform.shape != (4, 4) or not np.isfinite(transform).all():
        return False
    return bool(
        rotation_error(transform[:3, :3]) <= tolerance
        and np.linalg.det(transform[:3, :3]) > 0
        and np.abs(transform[3] - (0, 0, 0, 1)).max() <= tolerance
    )


def rotation_error(rotation: Float64Array) -> float:
    """How far a (3, 3) matrix is from orthonormal: max |R^T R - I|."""
    return float(np.abs(rotation.T @ rotation - np.eye(3)).max())


def nearest_rotation(matrix: Float64Array) -> Float64Array:
    """The proper rotation closest to a (3, 3) matrix in the Frobenius norm (orthogonal Procrustes)."""
    left, _, right = np.linalg.svd(matrix)
    return left @ np.diag([1.0, 1.0, np.sign(np.linalg.det(left @ right))]) @ right


def inverse(transform: Float64Array) -> Float64Array:
    """The inverse of a rigid (4, 4) transform."""
    result = np.eye(4)
    result[:3, :3] = transform[:3, :3].T
    result[:3, 3] = -transform[:3, :3].T @ transform[:3, 3]
    return result


def transform_points(transform: Float64Array, points: FloatArray) -> Float64Array:
    """Apply a (4, 4) transform to (..., 3) points."""
    # Written out, as BLAS hands even a (3, 3) factor to all its threads and waits for them.
    columns = [points[..., 0] * r[0] + points[..., 1] * r[1] + points[..., 2] * r[2] + r[3] for r in transform[:3]]
    return np.stack(columns, axis=-1)


def back_project(u: NDArray, v: NDArray, depth_m: NDArray, matrix: Float64Array) -> Float64Array:
    """Camera-frame points (N, 3) in metres, float64; pi^-1 of RAZER eq. 3.

    Args:
        u: Columns (N,) in pixels.
        v: Rows (N,) in pixels.
        depth_m: Depths (N,) along the optical axis, metres.
        matrix: Camera matrix (3, 3).
    """
    x = (u - matrix[0, 2]) / matrix[0, 0] * depth_m
    y = (v - matrix[1, 2]) / matrix[1, 1] * depth_m
    return np.stack([x, y, depth_m], axis=-1).astype(np.float64)


def project(points_camera: Float64Array, matrix: Float64Array) -> tuple[Float64Array, Float64Array, Float64Array]:
    """Pixel coordinates (u, v) and depth z, each (N,), of camera-frame points; z <= 0 gives nan pixels."""
    z = points_camera[..., 2]
    safe = np.where(z > 0, z, np.nan)
    u = points_camera[..., 0] / safe * matrix[0, 0] + matrix[0, 2]
    v = points_camera[..., 1] / safe * matrix[1, 1] + matrix[1, 2]
    return u, v, z
