"""Principal axes keep what tells descriptors apart, and with it the matches."""

from __future__ import annotations

import numpy as np
import pytest

from data_tools.synthetic.camera.sensor_model import SensorModel
from data_tools.synthetic.synthetic_scene import SyntheticScene
from slam.config import SlamConfig
from slam.frontend.color_calibration import ColorCalibration
from slam.frontend.wide_features import WideFeatures, match_wide_features, packed, root_sift, unit
from slam.sparse.principal_axes import AXES, LEARNT_FROM, principal_axes


def descriptors(n, rank, seed=0):
    """Packed descriptors (n, 64) that lie in a space of so many dimensions, all but for their rounding."""
    rng = np.random.default_rng(seed)
    mixed = rng.uniform(size=(n, rank)) @ rng.uniform(size=(rank, 128))
    return packed(np.square(15 * mixed / mixed.max()).astype(np.float32))


def test_axes_are_orthonormal_and_the_farthest_comes_first():
    given = [descriptors(300, 60, seed) for seed in (0, 1)]
    axes = principal_axes(given)
    assert axes.shape == (128, AXES)
    assert axes.dtype == np.float32
    np.testing.assert_allclose(axes.T @ axes, np.eye(AXES), atol=1e-5)
    energy = np.square(root_sift(np.concatenate(given)) @ axes).sum(axis=0)
    assert (np.diff(energy) <= 1e-3 * energy[0]).all()
    assert energy[0] > 10 * energy[1]  # all entries are positive


def test_angles_between_descriptors_of_few_dimensions_stay_as_they_are():
    roots = root_sift(descriptors(200, 20))
    along = unit(roots @ principal_axes([descriptors(200, 20)]))
    np.testing.assert_allclose(along @ along.T, roots @ roots.T, atol=0.01)


@pytest.mark.parametrize("n", [0, 1, 5])
def test_hardly_any_descriptors_have_axes_too(n):
    assert np.isfinite(principal_axes([descriptors(n, 2) if n else np.zeros((0, 64), np.uint8)])).all()
    assert principal_axes([]).shape == (128, AXES)


def test_of_many_descriptors_some_of_every_picture_are_looked_at():
    """The last of ten pictures varies where the others do not."""
    others = [packed(np.eye(128, dtype=np.float32)[:1].repeat(LEARNT_FROM // 4, 0) * 225) for _ in range(9)]
    last = packed(np.eye(128, dtype=np.float32)[77:78].repeat(LEARNT_FROM // 4, 0) * 225)
    axes = principal_axes([*others, last])
    assert np.square(axes[[0, 77]]).sum(axis=1) == pytest.approx([1, 1], abs=1e-5)


def test_views_match_along_axes_as_they_do_by_all_entries():
    room = SyntheticScene("room", 5, 60, sensor=SensorModel.kinect())
    config, camera = SlamConfig(), ColorCalibration.nominal()
    first, second = (WideFeatures(room[index], camera, config).features for index in (10, 22))
    axes = principal_axes(each.descriptors for each in (first, second))
    by_all = match_wide_features(first, second)
    along = match_wide_features(
        first, second, tuple(unit(root_sift(each.descriptors) @ axes) for each in (first, second))
    )
    same = set(map(tuple, by_all)) & set(map(tuple, along))
    assert len(by_all) > 30
    assert len(same) >= 0.9 * len(by_all)
    assert len(along) < 2 * len(by_all)
