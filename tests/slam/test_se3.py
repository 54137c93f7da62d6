"""Small motions of SE(3)."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from razer.geometry import is_rigid
from slam.se3 import adjoint, angle_deg, exp_se3, length_m

twists = st.lists(st.floats(-1, 1), min_size=6, max_size=6).map(np.array)


@given(twists, twists)
def test_the_adjoint_carries_small_motions_from_one_frame_to_the_other(pose, twist):
    transform, small = exp_se3(pose), 1e-6 * twist
    assert is_rigid(transform)
    carried = exp_se3(adjoint(transform) @ small) @ transform
    np.testing.assert_allclose(carried, transform @ exp_se3(small), atol=1e-11)


def test_angle_and_length_of_a_motion():
    turned = exp_se3(np.array([0.0, np.radians(30), 0.0, 0.0, 3.0, 4.0]))
    assert angle_deg(turned) == pytest.approx(30)
    assert length_m(turned) == pytest.approx(5)
    for degrees in (0.0, 90.0, 179.9999, 180.0):
        axis = np.array([0.48, 0.6, 0.64])
        assert angle_deg(exp_se3(np.append(np.radians(degrees) * axis, np.zeros(3)))) == pytest.approx(
            degrees, abs=1e-9
        )
    assert angle_deg(exp_se3(np.full(6, 1e-7))) == pytest.approx(np.degrees(np.sqrt(3) * 1e-7), rel=1e-6)
