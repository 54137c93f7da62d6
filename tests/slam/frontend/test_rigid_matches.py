"""Rigid matches of made-up features: the motion between two views, whatever else was matched."""

from __future__ import annotations

import numpy as np
import pytest

from razer.geometry import inverse
from slam.frontend.features import Features
from slam.frontend.rigid_matches import RigidMatches, absolute_orientations
from slam.frontend.wide_features import packed
from slam.se3 import angle_deg, exp_se3, length_m

TARGET_FROM_SOURCE = exp_se3(np.array([0.1, -0.7, 0.05, 0.6, 0.1, -0.2]))
N_TRUE, N_FALSE = 14, 40


def features(points, descriptors):
    n = len(points)
    rays = (points[:, :2] / points[:, 2:]).astype(np.float32)
    sigma, times = np.full(n, 0.001, np.float32), np.zeros(n, np.float32)
    return Features.of(rays, descriptors, points[:, 2].astype(np.float32), sigma, times)


def views(rng, n_true, n_false, noise_m=0.004):
    """Features of two views that match one to one, the first of which are of one scene."""
    seen = rng.uniform((-1, -1, 1.5), (1, 1, 3), (n_true + n_false, 3))
    source = seen @ inverse(TARGET_FROM_SOURCE)[:3, :3].T + inverse(TARGET_FROM_SOURCE)[:3, 3]
    source[:, 2] = np.maximum(source[:, 2], 0.3)
    source[n_true:] = rng.uniform((-1, -1, 1), (1, 1, 3), (n_false, 3))
    descriptors = packed(rng.uniform(0, 200, (n_true + n_false, 128)).astype(np.float32))
    source += rng.normal(0, noise_m, source.shape)
    return features(seen, descriptors), features(source, descriptors)


def test_features_of_one_scene_agree_and_say_how_the_camera_moved(rng):
    matches = RigidMatches(*views(rng, N_TRUE, N_FALSE))
    assert N_TRUE - 1 <= matches.n_agreeing <= N_TRUE + 8
    assert N_TRUE - 1 <= matches.n_explained <= N_TRUE + 2
    off = inverse(TARGET_FROM_SOURCE) @ matches.motion()
    assert length_m(off) < 0.03
    assert angle_deg(off) < 1


def test_the_motion_takes_in_what_it_explains_besides(rng):
    """A feature that agrees with too few of the others, as half of these are not where they were, is explained yet."""
    target, source = views(rng, 30, 0, noise_m=0.0)
    source.depth_m[:10] *= 1.2
    matches = RigidMatches(target, source)
    matches._agreeing = np.arange(10, 14)  # of those that stayed, as if only these had agreed
    assert matches.n_explained == 20
    np.testing.assert_allclose(matches.motion(), TARGET_FROM_SOURCE, atol=1e-4)


def test_of_views_that_share_nothing_hardly_any_agree(rng):
    counts = [RigidMatches(*views(rng, 0, N_FALSE)).n_agreeing for _ in range(20)]
    assert max(counts) < 12


def test_few_features_that_agree_are_a_hint_and_no_more(rng):
    found = [RigidMatches(*views(rng, 6, 20)) for _ in range(20)]
    assert not any(matches.is_sure for matches in found)
    hints = [matches for matches in found if matches.is_hint]
    assert len(hints) >= 15
    right = [length_m(inverse(TARGET_FROM_SOURCE) @ matches.motion()) < 0.2 for matches in hints]
    assert np.mean(right) >= 0.8
    assert sum(RigidMatches(*views(rng, 0, 20)).is_hint for _ in range(20)) <= 6
    assert not RigidMatches(*views(rng, 0, 0)).is_hint


def test_features_without_depth_take_no_part(rng):
    target, source = views(rng, N_TRUE, 0)
    blind = features(np.tile([0.0, 0.0, 1.0], (N_TRUE, 1)), source.descriptors)
    blind.depth_m[:] = 0
    assert RigidMatches(target, blind).n_agreeing == 0
    assert RigidMatches(blind, source).n_agreeing == 0


@pytest.mark.parametrize("n", [0, 1])
def test_hardly_any_features_match_nothing(rng, n):
    target, source = views(rng, n, 0)
    assert RigidMatches(target, source).n_agreeing <= n


def test_absolute_orientation_is_the_motion_of_points_that_moved(rng):
    here = rng.normal(0, 1, (5, 3))
    there = here @ TARGET_FROM_SOURCE[:3, :3].T + TARGET_FROM_SOURCE[:3, 3]
    np.testing.assert_allclose(absolute_orientations(here[None], there[None])[0], TARGET_FROM_SOURCE, atol=1e-9)


def test_information_is_how_much_features_move_when_the_motion_does(rng):
    """Each known to two centimetres and two in a hundred of its depth: by steps along each of six axes."""
    target, source = views(rng, 30, 0, noise_m=0.0)
    matches = RigidMatches(target, source)
    points = target.depth_m[:, None] * np.column_stack([target.rays, np.ones(30)])
    sigma_m = 0.02 + 0.02 * np.maximum(target.depth_m, source.depth_m)
    moved = [points @ exp_se3(step)[:3, :3].T + exp_se3(step)[:3, 3] for step in 1e-5 * np.eye(6)]
    changes = np.stack([((one - points) / 1e-5 / sigma_m[:, None]).ravel() for one in moved])
    np.testing.assert_allclose(matches.information, changes @ changes.T, rtol=0.01, atol=0.01 * 30 / 0.05**2)
