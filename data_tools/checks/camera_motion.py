"""Visual odometry between two frames (ORB features, PnP with RANSAC), to check declared poses against."""

from __future__ import annotations

from dataclasses import dataclass

import cv2
import numpy as np

from razer.arrays import Float32Array, Float64Array, Uint8Array
from razer.frame import Frame, Intrinsics
from razer.geometry import back_project

_FEATURES = 600
_INLIER_PIXELS = 3.0
_MIN_INLIERS = 30
_MIN_PIXEL_ERROR = 0.5  # no keypoint is better than that


@dataclass(frozen=True)
class Landmarks:
    """Features of one frame: pixels (N, 2), ORB descriptors (N, 32), depth (N,) metres, 0 = none."""

    pixels: Float64Array
    descriptors: Uint8Array
    depth_m: Float32Array


@dataclass(frozen=True)
class Motion:
    """Translation (3,) of b_from_a in the units of a's depth, and its information matrix (3, 3) with the
    rotation marginalised out: an error in a declared rotation then says nothing about translation; and what it
    was measured from, points (N, 3) in a's camera, in the same units, and where b sees them, (N, 2) pixels."""

    translation: Float64Array
    information: Float64Array
    points: Float64Array
    pixels: Float64Array

    def length(self, vector: Float64Array) -> float:
        """Length of a (3,) vector in standard deviations."""
        return float(np.sqrt(vector @ self.information @ vector))


def find_landmarks(frame: Frame) -> Landmarks:
    """The ORB features of a frame with the depth under each."""
    grey = cv2.cvtColor(frame.rgb, cv2.COLOR_RGB2GRAY)
    keypoints, descriptors = cv2.ORB.create(_FEATURES, fastThreshold=10).detectAndCompute(grey, None)
    if descriptors is None:
        return Landmarks(np.zeros((0, 2)), np.zeros((0, 32), np.uint8), np.zeros(0, np.float32))
    pixels = np.array([keypoint.pt for keypoint in keypoints])
    columns, rows = np.rint(pixels).astype(int).T
    return Landmarks(pixels, descriptors, frame.depth[rows, columns])


def measure_motion(a: Landmarks, b: Landmarks, camera: Intrinsics) -> Motion | None:
    """The motion that projects a's points where b sees them (PnP with RANSAC); None where too few features agree."""
    if min(len(a.pixels), len(b.pixels)) < _MIN_INLIERS:  # OpenCV cannot match none
        return None
    matches = cv2.BFMatcher(cv2.NORM_HAMMING, crossCheck=True).match(a.descriptors, b.descriptors)
    pairs = np.array([(m.queryIdx, m.trainIdx) for m in matches if a.depth_m[m.queryIdx] > 0])
    if len(pairs) < _MIN_INLIERS:
        return None
    (u, v), depth = a.pixels[pairs[:, 0]].T, a.depth_m[pairs[:, 0]]
    # Brought to a depth of one, so that a wrong scale cannot change which features agree.
    unit = float(np.median(depth))
    points = back_project(u, v, depth / unit, camera.matrix)
    solved = _solve_pnp(points, b.pixels[pairs[:, 1]], camera.matrix)
    if solved is None:
        return None
    return Motion(solved.translation * unit, solved.information / unit**2, solved.points * unit, solved.pixels)


def _solve_pnp(points: Float64Array, pixels: Float64Array, matrix: Float64Array) -> Motion | None:
    cv2.setRNGSeed(0)
    succeeded, rotation, translation, inliers = cv2.solvePnPRansac(
        points, pixels, matrix, None, iterationsCount=200, reprojectionError=_INLIER_PIXELS, flags=cv2.SOLVEPNP_EPNP
    )  # fmt: skip
    if not succeeded or inliers is None or len(inliers) < _MIN_INLIERS:
        return None
    points, pixels = points[inliers[:, 0]], pixels[inliers[:, 0]]
    rotation, translation = cv2.solvePnPRefineLM(points, pixels, matrix, None, rotation, translation)
    projected, jacobian = cv2.projectPoints(points, rotation, translation, matrix, None)
    variance = max(float(np.mean((projected[:, 0] - pixels) ** 2)), _MIN_PIXEL_ERROR**2)
    hessian = jacobian[:, :6].T @ jacobian[:, :6] / variance
    coupling = hessian[:3, 3:]
    information = hessian[3:, 3:] - coupling.T @ np.linalg.solve(hessian[:3, :3], coupling)
    return Motion(translation[:, 0], information, points, pixels)
