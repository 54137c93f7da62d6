"""Depth images of a few planes and boxes, worked out ray by ray, with what each pixel shows."""

from __future__ import annotations

import numpy as np
from scipy.spatial.transform import Rotation

from razer.frame import Frame, Intrinsics

CAMERA = Intrinsics(640, 480, 585.0, 585.0, 320.0, 240.0)
KINECT_STEP_PER_M = 0.00287  # inverse depth of one step of the disparity
SPECKLE_PER_M = 0.0008


def rays(camera: Intrinsics = CAMERA) -> np.ndarray:
    v, u = np.mgrid[: camera.height, : camera.width]
    directions = [(u - camera.cx) / camera.fx, (v - camera.cy) / camera.fy, np.ones_like(u)]
    return np.stack(directions, axis=-1).astype(float)


def plane(normal: tuple[float, float, float], distance_m: float) -> np.ndarray:
    """Depth (H, W) of the plane normal . X = distance, infinite where it is not hit."""
    along = rays() @ np.asarray(normal, float)
    return np.where(along > 1e-6, distance_m / np.maximum(along, 1e-6), np.inf)


def box(
    center: tuple[float, float, float], extent: tuple[float, float, float], turn_deg: tuple[float, float, float]
) -> np.ndarray:
    """Depth (H, W) of a box turned by Euler angles about the camera's axes x, y, z (slab method)."""
    camera_from_box = Rotation.from_euler("yxz", [turn_deg[1], turn_deg[0], turn_deg[2]], degrees=True).as_matrix()
    origin, directions = -np.asarray(center) @ camera_from_box, rays() @ camera_from_box
    directions = np.where(np.abs(directions) < 1e-9, 1e-9, directions)
    near = (-np.asarray(extent) / 2 - origin) / directions
    far = (np.asarray(extent) / 2 - origin) / directions
    enter, leave = np.minimum(near, far).max(axis=-1), np.maximum(near, far).min(axis=-1)
    return np.where(enter <= leave, enter, np.inf)


def scene(*surfaces: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """What is nearest: depth (H, W) float32, 0 beyond 10 m, and the number of the surface, -1 = none."""
    stack = np.stack(surfaces)
    depth, owner = stack.min(axis=0), stack.argmin(axis=0)
    seen = depth < 10
    return np.where(seen, depth, 0).astype(np.float32), np.where(seen, owner, -1)


def as_from_a_kinect(depth_m: np.ndarray, seed: int = 0) -> np.ndarray:
    """The depth with speckle, in steps of the disparity, in whole millimetres."""
    read = depth_m > 0
    inverse = 1 / np.where(read, depth_m, 1) + np.random.default_rng(seed).normal(0, SPECKLE_PER_M, depth_m.shape)
    steps = np.maximum(np.rint(inverse / KINECT_STEP_PER_M), 1)
    return np.where(read, np.rint(1000 / (steps * KINECT_STEP_PER_M)) / 1000, 0).astype(np.float32)


def frame_of(depth_m: np.ndarray, rgb: np.ndarray | None = None) -> Frame:
    grey = np.full((*depth_m.shape, 3), 128, np.uint8)
    return Frame(0, 0.0, grey if rgb is None else rgb, depth_m.astype(np.float32), CAMERA)
