"""Keyframes: the depth pyramids of those used last are kept, the others are made again."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from data_tools import open_sequence
from razer.frame import Intrinsics
from slam.config import SlamConfig
from slam.frontend import keyframes as module
from slam.frontend.color_calibration import ColorCalibration
from slam.frontend.depth_pyramid import DepthPyramid
from slam.frontend.features import FeatureExtractor
from slam.frontend.keyframes import STILL, Keyframes, View
from tests.slam.long_map_cost import view_bytes


class CountingPyramid(DepthPyramid):
    """Knows whether its grids are in memory."""

    @property
    def is_kept(self):
        return self._levels is not None


@pytest.fixture
def make_view(views):
    view = views[10]
    return lambda: replace(view, pyramid=CountingPyramid(view.pyramid.depth, view.pyramid.intrinsics))


def test_pyramids_used_last_are_kept_and_others_are_made_again_the_same(make_view, monkeypatch):
    monkeypatch.setattr(module, "KEPT_PYRAMIDS", 2)
    keyframes, views = Keyframes(), [make_view() for _ in range(3)]
    first = views[0].pyramid.levels
    for view in views:
        assert view.pyramid.levels is view.pyramid.levels
        keyframes.add(view, np.eye(4), 0, 0.0)
    assert [view.pyramid.is_kept for view in views] == [False, True, True]
    again = keyframes.view(keyframes[0]).pyramid.levels
    assert [view.pyramid.is_kept for view in views] == [True, False, True]
    for before, after in zip(first, again, strict=True):
        assert (before.points == after.points).all()
        assert (before.sample_normals == after.sample_normals).all()


def test_a_view_that_turned_otherwise_shares_its_pyramid(make_view):
    view = make_view()
    turned = view.turning(np.array([0.0, 1.0, 0.0]))
    assert turned.pyramid is view.pyramid
    assert (turned.turning_rad_s == [0, 1, 0]).all()


def test_stacked_poses_are_those_of_the_keyframes_however_these_are_moved(make_view):
    keyframes, rng = Keyframes(), np.random.default_rng(0)
    view = make_view()
    for number in range(150):
        keyframes.add(view, rng.normal(size=(4, 4)), number % 3, 0.0)
        keyframes[int(rng.integers(number + 1))].world_from_camera = rng.normal(size=(4, 4))
        if number % 7 == 0:
            np.testing.assert_array_equal(keyframes.poses(), [k.world_from_camera for k in keyframes.all])
    np.testing.assert_array_equal(keyframes.poses(), [k.world_from_camera for k in keyframes.all])
    assert keyframes.submaps().tolist() == [n % 3 for n in range(150)]


def n_bytes(value, seen):
    """Of all arrays that an object holds, each counted once, as large as what it keeps alive."""
    if isinstance(value, np.ndarray):
        while isinstance(value.base, np.ndarray):
            value = value.base
    if id(value) in seen:
        return 0
    seen.add(id(value))
    if isinstance(value, np.ndarray):
        return value.nbytes
    if isinstance(value, (list, tuple)):
        return sum(n_bytes(item, seen) for item in value)
    parts = vars(value).values() if hasattr(value, "__dict__") else ()
    return sum(n_bytes(part, seen) for part in parts)


def test_a_keyframe_at_rest_takes_little(views, make_view):
    view = views[10]
    keyframes = Keyframes()
    keyframe = keyframes.add(
        replace(view, pyramid=DepthPyramid(view.pyramid.depth, view.pyramid.intrinsics)), np.eye(4), 0, 0.0
    )
    assert keyframe.view.pyramid.levels is not None
    assert n_bytes(keyframe, set()) > 500_000
    keyframe.view.pyramid.release()
    assert len(view.features) > 400
    assert n_bytes(keyframe, set()) < 76_000 + 60 * len(view.features) + 160 * len(view.wide.features)


def test_depth_is_kept_far_more_finely_than_a_sensor_reads(rng):
    near = rng.uniform(0.3, 4.0, (120, 160)).astype(np.float32)
    near[rng.random(near.shape) < 0.2] = 0
    kept = DepthPyramid(near, Intrinsics(160, 120, 130.0, 130.0, 79.5, 59.5)).depth
    assert ((kept == 0) == (near == 0)).all()
    assert np.abs(kept - near).max() < 5e-5
    nothing = np.zeros((120, 160), np.float32)
    assert not DepthPyramid(nothing, Intrinsics(160, 120, 130.0, 130.0, 79.5, 59.5)).depth.any()


def test_keyframes_of_a_real_kitchen_are_small(real_data):
    config, nominal, clip = SlamConfig(), ColorCalibration.nominal(), open_sequence(real_data / "redkitchen")
    frames = [clip[n] for n in range(0, 600, 100)]
    views = [View.of(frame, FeatureExtractor(config).extract(frame, nominal), STILL, config) for frame in frames]
    assert np.mean([sum(view_bytes(view).values()) for view in views]) < 150_000
