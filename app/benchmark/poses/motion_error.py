"""Errors of motions between two cameras, and how large one must be to be false."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from razer.arrays import Pose
from razer.geometry import inverse
from slam.se3 import angle_deg, length_m

MAX_OFF_M, MAX_OFF_DEG = 0.3, 10.0  # beyond these no drift of the next neighbours, but another place


def is_false(a_from_b: Pose, true_a_from_b: Pose) -> bool:
    """Whether a motion (4, 4) is off the true one by more than MAX_OFF_M or MAX_OFF_DEG, or is not finite."""
    off = inverse(true_a_from_b) @ a_from_b
    return not np.isfinite(off).all() or length_m(off) > MAX_OFF_M or angle_deg(off) > MAX_OFF_DEG


def leads_astray(poses: Mapping[int, Pose], truth: Mapping[int, Pose], a: int, b: int) -> bool:
    """Whether the motion between frames a and b is false by their poses."""
    return is_false(inverse(poses[a]) @ poses[b], inverse(truth[a]) @ truth[b])
