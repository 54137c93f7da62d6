"""Outlier edges: what a finished graph contradicts, by how sure the edge is of itself, and whatever it says of that."""

from __future__ import annotations

import numpy as np
import pytest

from slam.backend.outlier_edges import MAX_MAHALANOBIS, MAX_OFF_M, is_outlier
from slam.backend.pose_graph import mahalanobis
from slam.pose_edge import PoseEdge
from slam.se3 import exp_se3

POSES = {0: np.eye(4), 1: exp_se3(np.array([0.1, 0, 0.2, 1.0, 0, 0]))}


def edge(off, sigma):
    """Off by a twist, in the frame of the second, each of whose numbers is known to sigma."""
    return PoseEdge(0, 1, POSES[1] @ exp_se3(np.array(off)), np.eye(6) / sigma**2)


@pytest.mark.parametrize(("n_sigmas", "outlier"), [(0.0, False), (0.9, False), (1.1, True)])
def test_an_edge_that_is_sure_of_another_motion_is_one(n_sigmas, outlier):
    sigma, step_m = 1e-4, 0.001
    off_m = n_sigmas * MAX_MAHALANOBIS * step_m / mahalanobis(edge([0, 0, 0, step_m, 0, 0], sigma), POSES)
    assert off_m < MAX_OFF_M
    assert is_outlier(edge([0, 0, 0, off_m, 0, 0], sigma), POSES) == outlier


@pytest.mark.parametrize(
    ("off", "outlier"),
    [([0, 0, 0, 0, 0.24, 0], False), ([0, 0, 0, 0, 0.26, 0], True),
     ([0, np.radians(4.9), 0, 0, 0, 0], False), ([0, np.radians(5.1), 0, 0, 0, 0], True)],
)  # fmt: skip
def test_an_edge_far_off_is_one_however_unsure_it_is(off, outlier):
    assert is_outlier(edge(off, 1.0), POSES) == outlier
