"""Boxes and surfaces of revolution: closed, and right side out."""

from __future__ import annotations

import numpy as np
import pytest

from data_tools.synthetic.shapes.solids import box, lathe, quad_normals
from data_tools.synthetic.shapes.thing import tinted
from tests.support.solids import signed_volume

GREY = tinted("plaster", (200.0, 200.0, 200.0))


def test_boxes_and_lathes_enclose_their_volume_facing_outwards() -> None:
    assert signed_volume(box((1, 2, 3), (2, 4, 6), GREY)) == pytest.approx(6)
    cylinder = lathe([(0, 0), (0.5, 0), (0.5, 2), (0, 2)], GREY, at=(3, 1), sides=24)
    assert signed_volume(cylinder) == pytest.approx(2 * 0.5 * 24 * 0.25 * np.sin(2 * np.pi / 24))
    normals = quad_normals(cylinder.quads)
    outwards = cylinder.quads.mean(axis=1) - (3, 1, 1)
    assert (np.einsum("qk,qk->q", normals, outwards) > 0).all()
