"""What can be said of solids."""

from __future__ import annotations

import numpy as np

from data_tools.synthetic.shapes.solids import Solid


def signed_volume(solid: Solid) -> float:
    """A sixth of the triple products of all triangles: the volume if the quads close and face outwards."""
    a, b, c, d = np.moveaxis(solid.quads, 1, 0)
    return float((np.einsum("qk,qk->", a, np.cross(b, c)) + np.einsum("qk,qk->", a, np.cross(c, d))) / 6)
