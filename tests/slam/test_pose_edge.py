"""Edges of a pose graph: how much they leave open."""

from __future__ import annotations

import numpy as np
import pytest

from razer.geometry import inverse
from slam.pose_edge import EDGE_SHARE, LEVER_M, PoseEdge
from slam.se3 import exp_se3, turn_rad


def test_what_an_edge_leaves_open_is_where_things_two_metres_ahead_are(rng):
    spread = rng.normal(size=(6, 6)) * 0.05
    covariance = spread @ spread.T + 0.01 * np.eye(6)
    edge = PoseEdge(0, 1, np.eye(4), np.linalg.inv(covariance) / EDGE_SHARE)
    ahead = np.array([0.0, 0.0, LEVER_M])
    jacobian = np.column_stack([*(np.cross(axis, ahead) for axis in np.eye(3)), np.eye(3)])
    assert edge.variance_m2 == pytest.approx(np.trace(jacobian @ covariance @ jacobian.T), rel=1e-6)


def test_an_edge_that_was_measured_the_other_way_round_says_the_same(rng):
    motion, spread = exp_se3(rng.normal(size=6)), rng.normal(size=(6, 6))
    information = spread @ spread.T
    as_measured, turned = (PoseEdge.between(*ends, motion, information) for ends in ((1, 3), (3, 1)))
    assert (as_measured.a, as_measured.b) == (turned.a, turned.b) == (1, 3)
    assert as_measured.information is information
    np.testing.assert_allclose(turned.a_from_b, inverse(motion), atol=1e-12)
    for axis in np.eye(6):  # an error of what was measured is one of its inverse, and as unlikely
        error = 1e-6 * axis
        off = inverse(exp_se3(error) @ motion) @ motion
        twist = np.concatenate([turn_rad(off), off[:3, 3]])
        assert twist @ turned.information @ twist == pytest.approx(error @ information @ error, rel=1e-4)
