"""Features that match from afar."""

from __future__ import annotations

import pickle

import numpy as np
import pytest

from razer.geometry import inverse
from slam.config import SlamConfig
from slam.frontend.color_calibration import ColorCalibration
from slam.frontend.features import FeatureExtractor, Features
from slam.frontend.keyframes import STILL, View
from slam.frontend.rigid_matches import RigidMatches
from slam.frontend.view_registration import ViewRegistration, is_trusted
from slam.frontend.wide_features import WideFeatures, levels, match_wide_features, packed, root_sift
from slam.se3 import angle_deg, length_m

NOMINAL = ColorCalibration.nominal()


def features(descriptors, depth_m):
    n = len(descriptors)
    return Features(np.zeros((n, 2)), packed(descriptors), np.full(n, depth_m), np.ones(n))


def test_pairs_are_mutual_and_by_far_the_best(rng):
    """Against the definition, one feature after the other."""
    there = rng.integers(0, 120, (40, 128)).astype(np.uint8)
    here = np.concatenate([there[[7, 3, 3]], rng.integers(0, 120, (20, 128)).astype(np.uint8)])
    here[2] = (here[2] + rng.integers(0, 30, 128)).astype(np.uint8)  # less like it than the one before
    there[11] = there[7]  # twice the same: neither is the best by far
    matched = match_wide_features(features(there, 1.0), features(here, 0.0))
    assert matched.tolist() == [[3, 1]]
    assert len(match_wide_features(features(there, 0.0), features(here, 1.0))) == 0


def test_descriptors_are_roots_in_sixteen_steps(rng):
    descriptors = rng.integers(0, 256, (50, 128)).astype(np.float32)
    kept = packed(descriptors)
    assert kept.nbytes == 50 * 64
    np.testing.assert_array_equal(levels(kept), np.minimum(np.round(np.sqrt(descriptors)), 15))
    assert levels(kept[:0]).shape == (0, 128)


def test_what_is_seen_lies_where_it_is(room):
    """Many of the features of two frames that match are the same points in the world."""
    frames = [room[i] for i in (10, 12)]
    a, b = (WideFeatures(frame, NOMINAL, SlamConfig()).features for frame in frames)
    pairs = match_wide_features(a, b)
    pairs = pairs[b.depth_m[pairs[:, 1]] > 0]
    points = [
        np.column_stack([f.rays, np.ones(len(f))])[n] * f.depth_m[n, None] @ frame.pose[:3, :3].T + frame.pose[:3, 3]
        for f, n, frame in ((a, pairs[:, 0], frames[0]), (b, pairs[:, 1], frames[1]))
    ]
    off_m = np.linalg.norm(points[0] - points[1], axis=1)
    assert (off_m < 0.02).sum() > 30


def test_any_number_of_the_first_features_are_spread_over_the_image(room):
    """One of each part of it comes before the second of any."""
    frame = room[10]
    k, found = frame.intrinsics, WideFeatures(frame, NOMINAL, SlamConfig()).features
    column, row = ((found.rays * (k.fx, k.fy) + (k.cx, k.cy) + 0.5) * (8 / k.width, 6 / k.height)).astype(int).T
    cell = row.clip(0, 5) * 8 + column.clip(0, 7)
    n_parts = len(np.unique(cell))
    assert n_parts >= 24
    assert len(np.unique(cell[:n_parts])) >= n_parts - 2  # by pixels that lie between two
    assert len(found) > 500


def test_prominent_features_come_first_whatever_is_left_out(room):
    wide = WideFeatures(room[10], NOMINAL, SlamConfig())
    n = wide.n_prominent
    assert 300 < n < len(wide.features) - 100
    left = wide.select(np.arange(len(wide.features)) % 3 > 0)
    assert left.n_prominent == (np.arange(n) % 3 > 0).sum()
    np.testing.assert_array_equal(left.prominent.rays, wide.prominent.rays[np.arange(n) % 3 > 0])
    assert len(left.features) == (np.arange(len(wide.features)) % 3 > 0).sum()
    assert pickle.loads(pickle.dumps(left)).n_prominent == left.n_prominent


def test_the_frame_is_let_go_once_its_features_are_known(room):
    wide = WideFeatures(room[10], NOMINAL, SlamConfig())
    state = wide.__getstate__()
    assert state["_frame"] is None
    assert wide._frame is None
    assert wide.features is state["_features"]
    assert wide.features.descriptors.shape[1] == 64


@pytest.mark.parametrize(("first", "second"), [(0, 96), (8, 104)])
def test_views_of_a_real_kitchen_apart_are_registered_without_a_guess(real_data, first, second):
    from data_tools.registry import open_sequence

    clip, extractor = open_sequence(real_data / "redkitchen"), FeatureExtractor(SlamConfig())
    frames = [clip[first], clip[second]]
    target, source = (View.of(f, extractor.extract(f, NOMINAL), STILL, SlamConfig()) for f in frames)
    rigid = RigidMatches(target.wide.features, source.wide.features)
    result = ViewRegistration(SlamConfig()).register(target, source, [], NOMINAL, rigid)
    assert result is not None
    assert is_trusted(result)
    off = inverse(inverse(frames[0].pose) @ frames[1].pose) @ result.target_from_source
    assert length_m(off) < 0.08
    assert angle_deg(off) < 3.0


def test_known_roots_lead_to_the_same_matches(real_data):
    from data_tools.registry import open_sequence

    clip, extractor = open_sequence(real_data / "redkitchen"), FeatureExtractor(SlamConfig())
    views = [View.of(clip[n], extractor.extract(clip[n], NOMINAL), STILL, SlamConfig()) for n in (0, 8)]
    target, source = (view.wide.features for view in views)
    pairs = match_wide_features(target, source)
    assert len(pairs) > 50
    roots = root_sift(target.descriptors), root_sift(source.descriptors)
    assert np.array_equal(match_wide_features(target, source, roots), pairs)
    assert not np.array_equal(match_wide_features(target, source, (roots[0][::-1], roots[1])), pairs)
