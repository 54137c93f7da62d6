"""Hand-made frames with instance and part ids for the oracle's profiles."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from razer.frame import Frame, Intrinsics


def true_frame(
    ids: np.ndarray,
    names: Mapping[int, str],
    index: int = 0,
    *,
    parts: np.ndarray | None = None,
    depth_m: float = 2.0,
    world_from_camera: np.ndarray | None = None,
) -> Frame:
    """A wall of ids (H, W) straight before the camera."""
    height, width = ids.shape
    camera = Intrinsics(width, height, float(width), float(width), width / 2, height / 2)
    rgb, depth = np.zeros((height, width, 3), np.uint8), np.full((height, width), depth_m, np.float32)
    pose = np.eye(4) if world_from_camera is None else world_from_camera
    numbers = None if parts is None else parts.astype(np.uint8)
    return Frame(index, index / 30, rgb, depth, camera, pose, ids.astype(np.int32), dict(names), part_ids=numbers)


def squares(rows: int, columns: int, cell: int, gap: int) -> np.ndarray:
    """Squares of `cell` pixels numbered from 1, `gap` pixels apart, 0 between them."""
    ids = np.zeros((rows * (cell + gap) + gap, columns * (cell + gap) + gap), np.int32)
    for number in range(rows * columns):
        y, x = gap + (number // columns) * (cell + gap), gap + (number % columns) * (cell + gap)
        ids[y : y + cell, x : x + cell] = number + 1
    return ids


def looking(azimuth_deg: float) -> np.ndarray:
    """world_from_camera of a camera at the origin that looks level in this direction about the world's z."""
    c, s = np.cos(np.radians(azimuth_deg)), np.sin(np.radians(azimuth_deg))
    pose = np.eye(4)
    pose[:3, :3] = np.array([[s, 0, c], [-c, 0, s], [0, -1, 0]])
    return pose
