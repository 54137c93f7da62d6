"""Transforms of solids: rotation, translation, scaling, and fitting of their texture."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from data_tools.synthetic.shapes.solids import Point, Solid

_WHOLE_TILE = np.array([(0, 1), (1, 1), (1, 0), (0, 0)], float)


def turned(solid: Solid, axis: str, degrees: float, at: Point = (0.0, 0.0, 0.0)) -> Solid:
    """The solid turned about one of the origin's axes, then moved.

    Args:
        solid: what.
        axis: x, y or z.
        degrees: ("x", -90) turns up to front.
        at: by which it is moved after that, metres.
    """
    cos, sin = np.cos(np.radians(degrees)), np.sin(np.radians(degrees))
    k = "xyz".index(axis)
    pose = np.eye(4)
    a, b = (k + 1) % 3, (k + 2) % 3
    pose[a, a], pose[a, b], pose[b, a], pose[b, b] = cos, -sin, sin, cos
    pose[:3, 3] = at
    return solid.moved(pose)


def shifted(solid: Solid, x: float, y: float, z: float) -> Solid:
    """The solid moved.

    Args:
        solid: what.
        x: metres.
        y: metres.
        z: metres.
    """
    return replace(solid, quads=np.add(solid.quads, (x, y, z)))


def stretched(solid: Solid, factors: Point) -> Solid:
    """The solid scaled along each axis by a positive factor."""
    return replace(solid, quads=solid.quads * factors)


def fitted(solid: Solid) -> Solid:
    """The solid with the whole texture, upright, on each of its rectangles."""
    uv = np.broadcast_to(_WHOLE_TILE * solid.material.tile_m, solid.uv.shape)
    return replace(solid, uv=uv.copy())
