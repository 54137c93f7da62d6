"""Given poses with known errors: the smooth drift of KinectFusion and ARKit, a jump, and noise from frame to frame."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise

import numpy as np
from scipy.spatial.transform import Rotation

Poses = Sequence[np.ndarray]


def drifting(poses: Poses, share: float = 0.01, deg_per_m: float = 1.0) -> list[np.ndarray]:
    """Poses whose steps are too long by a share of the way and turn by so much a metre about a slanted axis."""
    axis = np.array([0.3, 0.9, 0.3]) / np.linalg.norm([0.3, 0.9, 0.3])
    result = [poses[0].copy()]
    for before, after in pairwise(poses):
        step = np.linalg.inv(before) @ after
        turn = np.eye(4)
        turn[:3, :3] = Rotation.from_rotvec(axis * np.radians(deg_per_m) * np.linalg.norm(step[:3, 3])).as_matrix()
        step[:3, 3] *= 1 + share
        result.append(result[-1] @ step @ turn)
    return result


def noisy(poses: Poses, rng: np.random.Generator, sigma_m: float = 0.005, sigma_deg: float = 0.3) -> list[np.ndarray]:
    """Poses each off by normal noise of its own, along each axis."""
    result = []
    for pose in poses:
        off = np.eye(4)
        off[:3, :3] = Rotation.from_rotvec(np.radians(rng.normal(0, sigma_deg, 3))).as_matrix()
        off[:3, 3] = rng.normal(0, sigma_m, 3)
        result.append(pose @ off)
    return result


def jumping(poses: Poses, at: int, shift_m: float = 0.2, turn_deg: float = 4.0) -> list[np.ndarray]:
    """Poses whose world is another one from a frame on, as after a phone has relocalised wrongly."""
    moved = np.eye(4)
    moved[:3, :3] = Rotation.from_euler("y", turn_deg, degrees=True).as_matrix()
    moved[:3, 3] = shift_m, 0.0, 0.0
    return [*poses[:at], *(moved @ pose for pose in poses[at:])]
