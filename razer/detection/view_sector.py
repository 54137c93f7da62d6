"""Viewing sector: from which of twelve directions a thing is seen, about 60 degrees apart, whichever way is up."""

from __future__ import annotations

import numpy as np

from razer.arrays import Float64Array

_GOLDEN = (1 + np.sqrt(5)) / 2
# The corners of an icosahedron: three rectangles across each other.
_CORNERS = np.array(
    [np.roll((0, one, other), turn) for turn in range(3) for one in (-1, 1) for other in (-_GOLDEN, _GOLDEN)]
)


def view_sector(center: Float64Array, camera: Float64Array) -> int:
    """The sector, 0 to 11, from which a camera sees a thing: the corner of an icosahedron about the thing that is
    nearest to the direction of the camera. center (3,) and camera (3,) in the world, metres; a fixed partition, so that
    the order of frames changes nothing."""
    return int((_CORNERS @ (camera - center)).argmax())
