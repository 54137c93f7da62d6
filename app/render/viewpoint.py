"""Where to look from, so that a recording opens on something worth seeing."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from razer.arrays import Float64Array


@dataclass(frozen=True)
class Viewpoint:
    """An eye at `position` looking at `target`, both (3,) metres in the world, with `up` (3,) upwards."""

    position: Float64Array
    target: Float64Array
    up: Float64Array


def behind(world_from_camera: Float64Array, back_m: float = 1.5, ahead_m: float = 2.0) -> Viewpoint:
    """From behind and above a camera, looking where it looks."""
    up, forward, center = -world_from_camera[:3, 1], world_from_camera[:3, 2], world_from_camera[:3, 3]
    return Viewpoint(center - back_m * forward + 0.5 * back_m * up, center + ahead_m * forward, up)


def overview(points: Float64Array, up: Float64Array, forward: Float64Array, pitch_deg: float = 40.0) -> Viewpoint:
    """Down on (N, 3) points from outside, along the horizontal part of `forward`; strays do not count."""
    up = up / np.linalg.norm(up)
    level = forward - (forward @ up) * up
    level = level / np.linalg.norm(level) if np.linalg.norm(level) > 1e-6 else _any_normal_to(up)
    low, high = np.percentile(points, [3, 97], axis=0)
    target, size_m = (low + high) / 2, float(np.linalg.norm(high - low))
    pitch = np.radians(pitch_deg)
    return Viewpoint(target + 1.05 * size_m * (np.sin(pitch) * up - np.cos(pitch) * level), target, up)


def _any_normal_to(vector: Float64Array) -> Float64Array:
    normal = np.cross(vector, np.eye(3)[np.abs(vector).argmin()])
    return normal / np.linalg.norm(normal)
