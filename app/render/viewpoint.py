"""Initial viewpoints of the 3D viewer: behind a camera, and an overview of points."""

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
    """A view down on points from outside; outliers do not count.

    Args:
        points: (N, 3) metres.
        up: (3,) the direction that is up in the world.
        forward: (3,) the view looks along its horizontal part.
        pitch_deg: how steeply it looks down, degrees.
    """
    up = up / np.linalg.norm(up)
    horizontal = _horizontal(forward, up)
    low, high = np.percentile(points, [3, 97], axis=0)
    target, size_m = (low + high) / 2, float(np.linalg.norm(high - low))
    pitch = np.radians(pitch_deg)
    return Viewpoint(target + 1.05 * size_m * (np.sin(pitch) * up - np.cos(pitch) * horizontal), target, up)


def from_above(points: Float64Array, up: Float64Array, forward: Float64Array, least_m: float = 2.0) -> Viewpoint:
    """A view straight down on all points (N, 3), metres, with the horizontal part of `forward` upwards on the screen;
    never nearer than for an area of `least_m`."""
    up = up / np.linalg.norm(up)
    low, high = points.min(axis=0), points.max(axis=0)
    target, size_m = (low + high) / 2, max(float(np.linalg.norm(high - low)), least_m)
    return Viewpoint(target + 1.3 * size_m * up, target, _horizontal(forward, up))


def _horizontal(forward: Float64Array, up: Float64Array) -> Float64Array:
    """The direction (3,) of the horizontal part; any horizontal one where there is none."""
    horizontal = forward - (forward @ up) * up
    length = np.linalg.norm(horizontal)
    return horizontal / length if length > 1e-6 else _any_normal_to(up)


def _any_normal_to(vector: Float64Array) -> Float64Array:
    normal = np.cross(vector, np.eye(3)[np.abs(vector).argmin()])
    return normal / np.linalg.norm(normal)
