"""The NEES: of covariances made by hand, and of many errors drawn from them."""

from __future__ import annotations

import numpy as np
import pytest

from app.benchmark.poses.consistency import DEGREES_OF_FREEDOM, pose_nees
from slam.se3 import exp_se3

HOME = exp_se3(np.array([0.3, -0.2, 1.0, 4, 5, 6]))
CERTAIN = 1e-8 * np.eye(6)


def test_an_error_counts_by_its_standard_deviations():
    sigmas = np.array([0.01, 0.02, 0.03, 0.1, 0.2, 0.3])
    estimate = {0: np.eye(4), 5: exp_se3(np.array([0, 0.1, 0, 1, 0, 0]))}
    covariances = {0: CERTAIN, 5: np.diag(sigmas**2)}
    for axis in range(6):
        error = np.zeros(6)
        error[axis] = 2 * sigmas[axis]
        truth = {0: HOME, 5: HOME @ estimate[5] @ exp_se3(error)}
        assert pose_nees(estimate, covariances, truth) == pytest.approx([4.0], rel=1e-6)


def test_errors_drawn_from_the_covariances_have_a_mean_of_six():
    rng = np.random.default_rng(0)
    estimate, truth, covariances = {0: np.eye(4)}, {0: HOME}, {0: CERTAIN}
    for frame in range(1, 3001):
        root = rng.normal(0, 1e-3, (6, 6))
        estimate[frame] = exp_se3(rng.normal(0, 1, 6))
        covariances[frame] = root @ root.T + 1e-6 * np.eye(6)
        error = rng.multivariate_normal(np.zeros(6), covariances[frame])
        truth[frame] = HOME @ estimate[frame] @ exp_se3(error)
    nees = pose_nees(estimate, covariances, truth)
    assert len(nees) == 3000
    # The sum is chi-square distributed with 6 * 3000 degrees of freedom: within five standard deviations.
    assert nees.mean() == pytest.approx(DEGREES_OF_FREEDOM, abs=5 * np.sqrt(2 * 6 / 3000))
    halved = {frame: covariance / 4 for frame, covariance in covariances.items()}
    assert pose_nees(estimate, halved, truth).mean() == pytest.approx(4 * nees.mean())


def test_there_is_none_without_a_pose_beside_that_of_the_world():
    assert len(pose_nees({3: np.eye(4)}, {3: CERTAIN}, {3: HOME})) == 0
    assert len(pose_nees({}, {}, {})) == 0
