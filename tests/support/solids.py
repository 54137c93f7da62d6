"""What can be said of solids and layouts."""

from __future__ import annotations

import numpy as np

from data_tools.synthetic.scenes.living_room import Layout
from data_tools.synthetic.shapes.solids import Solid
from data_tools.synthetic.shapes.thing import Thing


def signed_volume(solid: Solid) -> float:
    """A sixth of the triple products of all triangles: the volume if the quads close and face outwards."""
    a, b, c, d = np.moveaxis(solid.quads, 1, 0)
    return float((np.einsum("qk,qk->", a, np.cross(b, c)) + np.einsum("qk,qk->", a, np.cross(c, d))) / 6)


def after_move(layout: Layout) -> dict[int, Thing]:
    """The things of a layout once the movable one stands elsewhere."""
    return {**layout.things, layout.movable: layout.elsewhere}
