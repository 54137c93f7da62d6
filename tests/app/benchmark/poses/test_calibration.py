"""Calibration of covariances: what its figures say of errors that are drawn, and of real runs."""

from __future__ import annotations

import numpy as np
import pytest

from app.benchmark.poses.calibration import FIGURES, described, mean_bounds, nees_figures, summary
from app.benchmark.poses.followed_walk import follow
from app.benchmark.poses.worlds.calibration_worlds import CALIBRATION_WORLDS
from slam.system import SlamSystem


@pytest.fixture
def rng() -> np.random.Generator:
    return np.random.default_rng(0)


def drawn_runs(times, rng, n_runs=24):
    """Runs of 30 keyframes whose errors have the covariances, times a factor."""
    rows = (times * (rng.normal(size=(30, 6)) ** 2).sum(axis=1) for _ in range(n_runs))
    return [{"world": "room", "seed": n, **nees_figures(nees)} for n, nees in enumerate(rows)]


def test_errors_drawn_from_the_covariances_lie_in_their_ellipsoids(rng):
    means = summary(drawn_runs(1.0, rng))
    assert means["share_in_50"] == pytest.approx(0.5, abs=0.05)
    assert means["share_in_95"] == pytest.approx(0.95, abs=0.02)
    assert means["nees"] == pytest.approx(6, abs=0.5)
    assert means["bounds"] == pytest.approx([4.69, 7.46], abs=0.01)
    assert "24 runs" in described(means)


@pytest.mark.parametrize("times", [0.5, 2.0])
def test_covariances_that_are_off_by_two_are_out_of_bounds(times, rng):
    means = summary(drawn_runs(times, rng))
    low, high = means["bounds"]
    for name in ("nees_halfway", "nees_last"):
        assert not low <= means[name] <= high


def test_the_mean_of_right_covariances_is_within_bounds_in_95_of_100_cases(rng):
    low, high = mean_bounds(20)
    means = rng.chisquare(6, (4000, 20)).mean(axis=1)
    assert ((low <= means) & (means <= high)).mean() == pytest.approx(0.95, abs=0.015)


def test_a_run_without_keyframes_says_nothing():
    assert nees_figures(np.zeros(0)) == dict.fromkeys(FIGURES)
    assert summary([{"world": "room", "seed": 1, **nees_figures(np.zeros(0))}])["runs"] == 0


@pytest.mark.full
def test_in_simulated_rooms_errors_are_as_large_as_covariances_say():
    """Where the scale is a constant, as it was, the mean is 0.1, and of a plain sensor half that of a Kinect."""
    names = [name for name in CALIBRATION_WORLDS if name.startswith(("room", "tabletop"))]
    rows = []
    for name in names:
        walk = CALIBRATION_WORLDS[name].walk(5, 90)
        rows.append(follow(walk, SlamSystem()).figures(walk.frames_per_s))
    assert len(rows) == 8
    for sensor in ("kinect", "plain"):
        of_sensor = [row["nees"] for name, row in zip(names, rows, strict=True) if name.endswith(sensor)]
        assert 1.5 < np.mean(of_sensor) < 12
    assert summary(rows)["share_in_95"] > 0.8
