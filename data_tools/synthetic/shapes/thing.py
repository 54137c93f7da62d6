"""One instance of a synthetic scene: a class name and the solids it is made of."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from data_tools.synthetic.shapes.solids import Colour, Material, Solid
from razer.arrays import Float64Array


@dataclass(frozen=True, slots=True)
class Thing:
    """One instance: a class name and the solids it is made of."""

    class_name: str
    solids: tuple[Solid, ...]

    def placed(self, x: float, y: float, z: float = 0.0, yaw_deg: float = 0.0) -> Thing:
        """The same thing turned about the vertical and put at a place.

        Args:
            x: metres.
            y: metres.
            z: metres.
            yaw_deg: about the vertical, degrees.
        """
        world_from_local = np.eye(4)
        cos, sin = np.cos(np.radians(yaw_deg)), np.sin(np.radians(yaw_deg))
        world_from_local[:2, :2] = [[cos, -sin], [sin, cos]]
        world_from_local[:3, 3] = x, y, z
        return self.moved(world_from_local)

    def moved(self, world_from_local: Float64Array) -> Thing:
        """The same thing after a rigid (4, 4) transform."""
        return Thing(self.class_name, tuple(s.moved(world_from_local) for s in self.solids))

    @property
    def bounds(self) -> tuple[Float64Array, Float64Array]:
        """The lowest and the highest corner (3,) of the axis-aligned box round the thing, metres."""
        corners = np.concatenate([solid.quads for solid in self.solids]).reshape(-1, 3)
        return corners.min(axis=0), corners.max(axis=0)


def tinted(texture: str, colour: Colour, contrast: float = 0.55, tile_m: float = 1.0) -> Material:
    """A material that varies from `colour` down to a share (1 - contrast) of it.

    Args:
        texture: a name of PAINTERS.
        colour: the brightest, RGB 0..255.
        contrast: how much darker the darkest is, share.
        tile_m: size of a tile of the texture, metres.
    """
    dark = tuple(c * (1 - contrast) for c in colour)
    return Material(texture, (dark[0], dark[1], dark[2]), colour, tile_m)
