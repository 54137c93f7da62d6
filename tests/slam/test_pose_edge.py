"""Edges of a pose graph: how much they leave open."""

from __future__ import annotations

import numpy as np
import pytest

from slam.pose_edge import EDGE_SHARE, LEVER_M, PoseEdge


def test_what_an_edge_leaves_open_is_where_things_two_metres_ahead_are(rng):
    spread = rng.normal(size=(6, 6)) * 0.05
    covariance = spread @ spread.T + 0.01 * np.eye(6)
    edge = PoseEdge(0, 1, np.eye(4), np.linalg.inv(covariance) / EDGE_SHARE)
    ahead = np.array([0.0, 0.0, LEVER_M])
    jacobian = np.column_stack([*(np.cross(axis, ahead) for axis in np.eye(3)), np.eye(3)])
    assert edge.variance_m2 == pytest.approx(np.trace(jacobian @ covariance @ jacobian.T), rel=1e-6)
