"""Consistency of an estimate with its covariances: the normalised estimation error squared, NEES (Bar-Shalom, Li and
Kirubarajan 2001)."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from scipy.spatial.transform import Rotation

from razer.arrays import Float64Array, Pose
from razer.geometry import inverse

DEGREES_OF_FREEDOM = 6  # the mean of the NEES of covariances that are right


def pose_nees(
    poses: Mapping[int, Pose], covariances: Mapping[int, Float64Array], truth: Mapping[int, Pose]
) -> Float64Array:
    """The NEES (K,) e^T C^-1 e of poses with their covariances (6, 6), all by frame, against true poses in a world of
    their own. e is the small motion (rotation, radians; shift, metres) along the camera's own axes from the estimated
    pose to the true one. The most certain pose, which is the world's, is left out: the two worlds agree in it."""
    if len(covariances) < 2:
        return np.zeros(0)
    home = min(covariances, key=lambda frame: float(np.trace(covariances[frame])))
    world_from_truth = poses[home] @ inverse(truth[home])
    others = [frame for frame in covariances if frame != home]
    return np.array([_nees(inverse(poses[n]) @ world_from_truth @ truth[n], covariances[n]) for n in others])


def _nees(off: Pose, covariance: Float64Array) -> float:
    error = np.concatenate([Rotation.from_matrix(off[:3, :3]).as_rotvec(), off[:3, 3]])
    return float(error @ np.linalg.solve(covariance, error))
