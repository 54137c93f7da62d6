"""Small motions of SE(3): the exponential map, angles, and how information moves from one frame to another."""

from __future__ import annotations

import math

import cv2
import numpy as np
from scipy.spatial.transform import Rotation

from razer.arrays import Float64Array


def exp_se3(twist: Float64Array) -> Float64Array:
    """The rigid motion (4, 4) that turns by the rotation vector twist[:3] (radians) and then shifts by twist[3:]
    (metres): a retraction of SE(3), exact to first order."""
    result = np.eye(4)
    result[:3, :3] = cv2.Rodrigues(np.asarray(twist[:3], np.float64))[0]
    result[:3, 3] = twist[3:]
    return result


def angle_deg(transform: Float64Array) -> float:
    """The rotation angle of a rigid motion in degrees, accurate near 0 as well."""
    r = transform
    sine = math.hypot(r[2, 1] - r[1, 2], r[0, 2] - r[2, 0], r[1, 0] - r[0, 1])
    return math.degrees(math.atan2(sine, r[0, 0] + r[1, 1] + r[2, 2] - 1))


def turn_rad(transform: Float64Array) -> Float64Array:
    """The rotation vector (3,) of a rigid motion, radians."""
    return Rotation.from_matrix(transform[:3, :3]).as_rotvec()


def length_m(transform: Float64Array) -> float:
    """The length of a rigid motion's shift in metres."""
    return float(np.linalg.norm(transform[:3, 3]))


def orthonormal(transform: Float64Array) -> Float64Array:
    """The transform with rounding errors of its rotation removed, as long products need."""
    result = np.eye(4)
    left, _, right = np.linalg.svd(transform[:3, :3])
    result[:3, :3] = left @ right
    result[:3, 3] = transform[:3, 3]
    return result


def adjoint(transform: Float64Array) -> Float64Array:
    """Ad_T (6, 6) for twists (rotation, shift): T exp(x) = exp(Ad_T x) T."""
    rotation, shift = transform[:3, :3], transform[:3, 3]
    cross = np.array([[0, -shift[2], shift[1]], [shift[2], 0, -shift[0]], [-shift[1], shift[0], 0]])
    result = np.zeros((6, 6))
    result[:3, :3] = result[3:, 3:] = rotation
    result[3:, :3] = cross @ rotation
    return result
