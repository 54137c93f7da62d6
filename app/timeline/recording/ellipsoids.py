"""Covariance ellipsoids of estimated positions."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from razer.arrays import Float64Array


@dataclass(frozen=True)
class Ellipsoids:
    """Centres (K, 3) and half sizes (K, 3) in metres, and rotations (K, 3, 3) whose columns are the axes."""

    centers: Float64Array
    half_sizes: Float64Array
    rotations: Float64Array


def position_ellipsoids(world_from_camera: Float64Array, covariances: Float64Array, sigmas: float = 1.0) -> Ellipsoids:
    """`sigmas` standard deviations of the positions of poses (K, 4, 4), whose covariances (K, 6, 6) of rotation and
    shift are along the cameras' own axes."""
    variances, axes = np.linalg.eigh(covariances[:, 3:, 3:])
    axes[np.linalg.det(axes) < 0, :, 0] *= -1  # a mirror is no rotation
    half_sizes = sigmas * np.sqrt(variances.clip(min=0))
    return Ellipsoids(world_from_camera[:, :3, 3], half_sizes, world_from_camera[:, :3, :3] @ axes)
