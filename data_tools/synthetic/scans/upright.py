"""Upright frame of a scan: which way is up, and how high the floor lies, by its horizontal surfaces."""

from __future__ import annotations

import numpy as np

from data_tools.synthetic.scans.surface import ScannedSurface
from data_tools.truth.ground_truth import GroundTruth
from razer.arrays import Float64Array
from razer.errors import BadInput

AXES = {f"{sign}{axis}": s * np.eye(3)[k] for sign, s in (("", 1), ("-", -1)) for k, axis in enumerate("xyz")}
# Most datasets have z up, within these degrees: another axis must be so much likelier to be believed.
_Z_FAVOUR, _Z_DEG = 1.2, 12.0
# What furniture below the middle of a room tells, beside level surface: in rooms, flats and corridors with and without
# a ceiling it is 0.04 to 0.15 along the axis that is up and below 0.03 along others, of which walls make level surface.
_SKEW_OFFSET = 0.05
_CONES_DEG = (40.0, 20.0, 10.0, 5.0)
_LEVEL_COS = 0.95
# z is turned only where surfaces clearly hang above the middle.
_HANGING = 0.1
_FLOOR_BIN_M, _FLOOR_SHARE = 0.05, 0.2


def upright_from_mesh(truth: GroundTruth, up: str) -> list[Float64Array]:
    """Rigid transforms (4, 4) that turn a mesh to z up and put its floor to z = 0 and its middle over the origin, the
    likeliest first.

    up: one of AXES or x,y,z of any direction: there is one transform. Or auto: one for each axis, or what is within 40
    degrees of it, likelier the more surface is level to it and the more of all lies below the middle. Raises BadInput.
    """
    surface = ScannedSurface.of(truth.vertices, truth.triangles, truth.instances, truth.colors)
    directions = _up_directions(surface) if up == "auto" else [parse_up(up)]
    return [_upright(surface, direction) for direction in directions]


def parse_up(text: str) -> Float64Array:
    """The unit direction (3,) that a name in AXES or three numbers mean; raises BadInput."""
    name = text.removeprefix("+")
    if name in AXES:
        return AXES[name]
    try:
        direction = np.array([float(part) for part in text.split(",")])
    except ValueError:
        direction = np.zeros(0)
    if direction.shape != (3,) or not 0 < np.linalg.norm(direction) < np.inf:
        raise BadInput(f"--up {text}: give auto, one of {', '.join(AXES)}, or three numbers x,y,z")
    return direction / np.linalg.norm(direction)


def _upright(surface: ScannedSurface, up: Float64Array) -> Float64Array:
    transform = np.eye(4)
    transform[:3, :3] = _turned_to_z(up)
    points = surface.vertices[surface.triangles[:, 0]] @ transform[:3, :3].T
    middle = (points.min(axis=0) + points.max(axis=0)) / 2
    transform[:3, 3] = -middle[0], -middle[1], -_floor_height(surface, up)
    return transform


def _up_directions(surface: ScannedSurface) -> list[Float64Array]:
    axes = [_settled(surface, axis) for axis in np.eye(3)]
    level = [surface.areas[np.abs(surface.normals @ axis) > _LEVEL_COS].sum() for axis in axes]
    skew = [_furniture_below(surface, axis) for axis in axes]
    favour = [1.0, 1.0, 1.0]
    if axes[2][2] > np.cos(np.radians(_Z_DEG)):
        favour[2], skew[2] = _Z_FAVOUR, max(skew[2], 0.0) if skew[2] > -_HANGING else skew[2]
    likely = np.array(favour) * level * (_SKEW_OFFSET + np.abs(skew))
    return [-axes[k] if skew[k] < 0 else axes[k] for k in np.argsort(-likely, kind="stable")]


def _furniture_below(surface: ScannedSurface, axis: Float64Array) -> float:
    """By how much the mean height of the surface along an axis lies below the middle, a share of its extent."""
    heights = surface.vertices[surface.triangles[:, 0]] @ axis
    low, high = np.quantile(heights, (0.01, 0.99))
    mean = float(np.average(heights.clip(low, high), weights=surface.areas))
    return 0.5 - (mean - low) / max(high - low, 1e-9)


def _settled(surface: ScannedSurface, axis: Float64Array) -> Float64Array:
    """The direction that most surface within ever narrower cones round an axis is level to."""
    for cone in _CONES_DEG:
        along = surface.normals @ axis
        near = np.abs(along) > np.cos(np.radians(cone))
        mean = ((surface.normals * np.sign(along)[:, None])[near] * surface.areas[near, None]).sum(axis=0)
        if not (length := np.linalg.norm(mean)) > 0:
            return axis
        axis = mean / length
    return axis


def _turned_to_z(up: Float64Array) -> Float64Array:
    """The least rotation (3, 3) that takes a direction to z."""
    axis, cos = np.cross(up, (0, 0, 1)), up[2]
    if cos < -1 + 1e-9:
        return np.diag([1.0, -1.0, -1.0])
    x, y, z = axis
    skew = np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])
    return np.eye(3) + skew + skew @ skew / (1 + cos)


def _floor_height(surface: ScannedSurface, up: Float64Array) -> float:
    """The height of the lowest large level surface along `up`; of the lowest vertices where nothing is level."""
    level = np.abs(surface.normals @ up) > _LEVEL_COS
    heights = surface.vertices[surface.triangles].mean(axis=1) @ up
    if not level.any():
        return float(np.quantile(heights, 0.01))
    bins = np.floor((heights[level] - heights.min()) / _FLOOR_BIN_M).astype(int)
    areas = np.convolve(np.bincount(bins, surface.areas[level]), np.ones(3), "same")
    large = int(np.flatnonzero(areas >= _FLOOR_SHARE * areas.max())[0])
    peak = large + int(areas[large : large + 4].argmax())
    near = np.abs(bins - peak) <= 1
    return float(np.average(heights[level][near], weights=surface.areas[level][near]))
