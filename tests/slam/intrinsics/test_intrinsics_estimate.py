"""Intrinsics from pairs of views: found again from wrong guesses, and not claimed where views do not tell them."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from razer.arrays import Float64Array
from razer.frame import Intrinsics
from razer.geometry import transform_points
from slam.config import DepthSettings
from slam.frontend.depth_noise import DepthNoise
from slam.frontend.rigid_matches import absolute_orientations
from slam.intrinsics.camera_adjustment import ViewPair
from slam.intrinsics.intrinsics_estimate import IntrinsicsEstimate, estimate_intrinsics
from slam.intrinsics.matched_views import ViewMatches, rigid_start
from slam.se3 import exp_se3

TRUE = Intrinsics(640, 480, 517.3, 516.5, 318.6, 255.3)
N_PAIRS, N_GROUPS, N_POINTS = 24, 6, 120
DEPTH = DepthSettings()


def numbers(camera: Intrinsics) -> Float64Array:
    return np.array([camera.fx, camera.fy, camera.cx, camera.cy])


def projected(points: Float64Array) -> Float64Array:
    return points[:, :2] / points[:, 2:] * (TRUE.fx, TRUE.fy) + (TRUE.cx, TRUE.cy)


def seen(points: Float64Array, motion: Float64Array, rng: np.random.Generator, pixel_sigma: float) -> ViewMatches:
    """What two views see of points (N, 3) in front of the first, with noise of pixels and of depth in proportion."""
    there = transform_points(motion, points)
    visible = (there[:, 2] > 0.3) & (np.abs(projected(there) - (320, 240)) < (320, 240)).all(axis=1)
    pixels, depths = [], []
    for view in (points[visible], there[visible]):
        pixels.append(projected(view) + rng.normal(0, pixel_sigma, (len(view), 2)) if pixel_sigma else projected(view))
        noise = DepthNoise(DEPTH).at_rest(view[:, 2]) * (pixel_sigma > 0)
        depths.append(view[:, 2] + noise * rng.normal(size=len(view)))
    sigma = np.full(int(visible.sum()), max(pixel_sigma, 0.5))
    return ViewMatches(pixels[0], depths[0], pixels[1], depths[1], sigma)


def in_view(rng: np.random.Generator, depths_m: Float64Array) -> Float64Array:
    pixels = rng.uniform((0, 0), (640, 480), (len(depths_m), 2))
    return (
        np.column_stack([(pixels - (TRUE.cx, TRUE.cy)) / (TRUE.fx, TRUE.fy), np.ones(len(depths_m))])
        * depths_m[:, None]
    )


def turned(rng: np.random.Generator) -> Float64Array:
    return exp_se3(np.concatenate([rng.choice([-1, 1], 3) * rng.uniform(0.1, 0.35, 3), rng.normal(0, 0.15, 3)]))


def views(motion_of, depths_of=None, pixel_sigma: float = 0.7, seed: int = 0) -> list[ViewPair]:
    rng, pairs = np.random.default_rng(seed), []
    for number in range(N_PAIRS):
        depths = rng.uniform(0.8, 3.5, N_POINTS) if depths_of is None else depths_of(rng)
        matches = seen(in_view(rng, depths), motion_of(rng), rng, pixel_sigma)
        pairs.append(ViewPair(matches, number * N_GROUPS // N_PAIRS))
    return pairs


def guessed(factor: float, shift_px: float = 0.0) -> Intrinsics:
    return replace(TRUE, fx=TRUE.fx * factor, fy=TRUE.fy * factor, cx=TRUE.cx + shift_px, cy=TRUE.cy - shift_px)


def in_sigmas(found: IntrinsicsEstimate) -> Float64Array:
    return (numbers(found.intrinsics) - numbers(TRUE)) / found.sigma_px


@pytest.mark.parametrize("factor", [0.7, 0.8, 1.2, 1.4])
def test_a_camera_is_found_again_from_a_wrong_guess(factor):
    found = estimate_intrinsics(views(turned), guessed(factor, 10), DEPTH)
    assert found.confident, found.reason
    assert np.abs(numbers(found.intrinsics) - numbers(TRUE))[:2].max() < 0.005 * TRUE.fx
    assert np.abs(in_sigmas(found)).max() < 4
    assert max(found.sigma_px[:2]) < 0.005 * TRUE.fx


def test_without_noise_it_is_exact():
    found = estimate_intrinsics(views(turned, pixel_sigma=0.0), guessed(0.8), DEPTH)
    assert np.allclose(numbers(found.intrinsics), numbers(TRUE), atol=0.05)


def test_what_is_claimed_is_what_it_errs_by():
    """Over many draws of the noise errors are as large as their claimed deviations, neither far less nor far more."""
    errors = np.array(
        [in_sigmas(estimate_intrinsics(views(turned, seed=seed), guessed(1.1), DEPTH)) for seed in range(12)]
    )
    assert 0.3 < np.sqrt((errors**2).mean()) < 1.6


def test_a_third_of_wrong_matches_does_no_harm():
    rng, pairs = np.random.default_rng(5), []
    for pair in views(turned, seed=4):
        wrong = rng.random(len(pair.matches)) < 0.33
        second = pair.matches.second_px.copy()
        second[wrong] = rng.uniform((0, 0), (640, 480), (int(wrong.sum()), 2))
        pairs.append(replace(pair, matches=replace(pair.matches, second_px=second)))
    found = estimate_intrinsics(pairs, guessed(0.9, 10), DEPTH)
    assert found.confident
    assert np.abs(in_sigmas(found)).max() < 4


def forward(rng: np.random.Generator) -> Float64Array:
    return exp_se3(np.array([0, 0, 0, 0, 0, -rng.uniform(0.2, 0.6)]))


def aside(rng: np.random.Generator) -> Float64Array:
    return exp_se3(np.array([0, 0, 0, *rng.uniform(-0.4, 0.4, 2), 0]))


def flat(rng: np.random.Generator) -> Float64Array:
    return np.full(N_POINTS, 2.0)


@pytest.mark.parametrize(
    ("motion", "depths"), [(forward, None), (forward, flat), (aside, flat), (aside, None)],
    ids=["forward", "forward to a wall", "along a wall", "aside"],
)  # fmt: skip
def test_views_that_did_not_turn_say_that_they_cannot_tell(motion, depths):
    found = estimate_intrinsics(views(motion, depths), guessed(1.1), DEPTH)
    assert not found.confident
    assert "open by" in found.reason


def test_few_pairs_of_views_are_said_to_be_few():
    found = estimate_intrinsics(views(turned)[:3], guessed(1.1), DEPTH)
    assert not found.confident
    assert "only 3 pairs" in found.reason
    assert found.intrinsics == guessed(1.1)
    assert not estimate_intrinsics([], guessed(1.1), DEPTH).confident


def test_a_rigid_start_is_the_motion_between_the_views():
    rng = np.random.default_rng(2)
    motion = turned(rng)
    matches = seen(in_view(rng, rng.uniform(1, 3, N_POINTS)), motion, rng, 0.3)
    start = rigid_start(matches, numbers(TRUE), DepthNoise(DEPTH))
    assert start.explained.mean() > 0.95
    assert np.allclose(start.second_from_first, motion, atol=0.02)


def test_absolute_orientation_never_mirrors():
    rng = np.random.default_rng(3)
    points = rng.normal(size=(4, 5, 3))
    motions = np.stack([turned(rng) for _ in range(4)])
    moved = np.stack([transform_points(motion, part) for motion, part in zip(motions, points, strict=True)])
    assert np.allclose(absolute_orientations(points, moved), motions, atol=1e-9)
    assert np.allclose(np.linalg.det(absolute_orientations(points, points * (1, 1, -1))[:, :3, :3]), 1)
