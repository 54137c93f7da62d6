"""How much two views share, told from a few readings of each or from where they are: cheap enough to be asked of many
pairs."""

from __future__ import annotations

import numpy as np

from razer.arrays import Float32Array, Float64Array, IndexArray
from slam.config import LoopClosureSettings
from slam.frontend.depth_pyramid import MIN_DEPTH_M
from slam.frontend.keyframes import View
from slam.se3 import angle_deg, length_m

REACH_M = 0.3  # a point this far from a reading may lie on its surface, for all that drift has done
SAMPLE = 2  # every so many-th reading is looked at


def reading_points(view: View, max_depth_m: float) -> Float32Array:
    """Points (3, N) metres in the camera's frame of some of a view's readings up to a depth."""
    k, flat = view.sparse.intrinsics, view.sparse.depth.ravel().astype(np.float32)
    pixel = np.flatnonzero((flat > 0) & (flat <= max_depth_m))[::SAMPLE]
    row, column = np.divmod(pixel, k.width)
    z = flat[pixel]
    return np.stack([(column - k.cx) / k.fx * z, (row - k.cy) / k.fy * z, z]).astype(np.float32)


def overlap_of(points: Float32Array, other: View, other_from_view: Float64Array) -> float:
    """Share of the points (3, N) of a view that project onto readings of another within REACH_M of them.

    Args:
        points: as `reading_points` gives them.
        other: the other view.
        other_from_view: (4, 4) the motion between the two, as far as known.
    """
    k, moved = other.sparse.intrinsics, other_from_view.astype(np.float32)
    x, y, z = moved[:3, :3] @ points + moved[:3, 3:]
    ahead = np.flatnonzero(z > MIN_DEPTH_M)
    x, y, z = x[ahead], y[ahead], z[ahead]
    column = np.rint(x / z * np.float32(k.fx) + np.float32(k.cx))
    row = np.rint(y / z * np.float32(k.fy) + np.float32(k.cy))
    inside = np.flatnonzero((column >= 0) & (row >= 0) & (column < k.width) & (row < k.height))
    read = other.sparse.depth[row[inside].astype(np.intp), column[inside].astype(np.intp)]
    near = (read > 0) & (np.abs(read - z[inside]) < REACH_M)
    return float(near.sum()) / max(points.shape[1], 1)


def near_poses(world_from_camera: Float64Array, poses: Float64Array, settings: LoopClosureSettings) -> IndexArray:
    """Rows of poses (K, 4, 4) that may see what another does, the nearest first.

    Args:
        world_from_camera: (4, 4) the other.
        poses: world_from_camera of each.
        settings: how far away they may be.
    """
    away = np.linalg.norm(poses[:, :3, 3] - world_from_camera[:3, 3], axis=1) / settings.max_distance_m
    cosine = poses[:, :3, 2] @ world_from_camera[:3, 2]
    least = np.cos(np.radians(settings.max_angle_deg))
    near = np.flatnonzero((away < 1) & (cosine > least))
    return near[np.argsort(away[near] - cosine[near], kind="stable")]


def separation(view: View, other: View, view_from_other: Float64Array) -> float:
    """How far apart two views were taken: the baseline in units of the depth that they see, plus the angle in radians.

    Args:
        view: one view.
        other: the other.
        view_from_other: (4, 4) the motion between the two.
    """
    depth_m = (view.median_depth_m + other.median_depth_m) / 2
    return length_m(view_from_other) / depth_m + float(np.radians(angle_deg(view_from_other)))
