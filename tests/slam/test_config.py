"""Settings of the pose estimation: each is documented, checked, and does what it says."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from pydantic import ValidationError

from data_tools import open_sequence
from slam.config import ColorSettings, DepthSettings, FeatureSettings, KeyframeSettings, SlamConfig
from slam.frontend.color_calibration import NOMINAL, READOUT, ColorCalibration
from slam.frontend.depth_noise import DepthNoise
from slam.frontend.features import FeatureExtractor
from slam.frontend.frame_tracker import needs_keyframe
from slam.frontend.icp import IcpResult
from slam.frontend.keyframes import STILL, View
from slam.se3 import exp_se3
from slam.system import SlamSystem

FIELDS = [
    (f"{section}.{name}", field) for section, group in SlamConfig() for name, field in type(group).model_fields.items()
]


@pytest.mark.parametrize(("name", "field"), FIELDS, ids=[name for name, _ in FIELDS])
def test_every_setting_has_a_range_and_says_what_each_direction_costs(name, field):
    assert field.metadata or field.annotation is bool, name
    directions = ("maller", "arger", "Off", "; 1:", "; 0:")
    assert any(word in field.description for word in directions), name


def test_settings_without_sense_are_refused():
    with pytest.raises(ValidationError, match="no feature to each of 40 x 40 cells"):
        FeatureSettings(grid_rows=40, grid_columns=40)
    with pytest.raises(ValidationError):
        KeyframeSettings(max_shift_m=0)
    with pytest.raises(ValidationError):
        SlamConfig(loop_closures={})


@pytest.fixture(scope="module")
def turning_frames(real_data):
    """freiburg1_rpy: the camera turns by up to 110 degrees a second, and its colour sensor is read row by row."""
    clip = open_sequence(real_data / "tum_fr1_rpy_head")
    return [replace(clip[index], world_from_camera=None) for index in range(25)]


def learnt_from(frames, config):
    slam = SlamSystem(config)
    poses = [slam.locate(frame) for frame in frames]
    assert all(pose is not None for pose in poses)
    slam.finish()
    return slam.calibration


def test_the_readout_of_a_rolling_shutter_is_learnt_if_switched_on(turning_frames):
    learnt = learnt_from(turning_frames, SlamConfig())
    assert learnt.parameters[READOUT] > 0.001
    assert learnt.information[READOUT, READOUT] > ColorCalibration.nominal().information[READOUT, READOUT]


def test_without_a_rolling_shutter_all_but_the_readout_is_learnt(turning_frames):
    learnt = learnt_from(turning_frames, SlamConfig(color=ColorSettings(rolling_shutter=False)))
    before = ColorCalibration.nominal()
    assert learnt.parameters[READOUT] == 0.0
    assert (learnt.information[READOUT] == before.information[READOUT]).all()
    assert (learnt.parameters[:READOUT] != NOMINAL[:READOUT]).all()
    assert (np.diag(learnt.information)[:READOUT] > np.diag(before.information)[:READOUT]).all()


def test_without_a_rolling_shutter_all_rows_are_of_one_moment(room):
    extract = {
        on: FeatureExtractor(SlamConfig(color=ColorSettings(rolling_shutter=on))).extract(
            room[10], ColorCalibration.nominal()
        )
        for on in (True, False)
    }
    assert np.ptp(extract[True].row_times) > 0.5
    assert not extract[False].row_times.any()
    assert (extract[True].rays == extract[False].rays).all()


def test_features_are_as_many_and_as_spread_as_the_settings_say(room):
    def features(**settings):
        config = SlamConfig(features=FeatureSettings(**settings))
        return FeatureExtractor(config).extract(room[10], ColorCalibration.nominal())

    assert len(features(count=450)) <= 450 < len(features())
    columns = room.intrinsics.fx * features(count=400, grid_rows=1, grid_columns=2).rays[:, 0] + room.intrinsics.cx
    # Cells are those of the corners as OpenCV reports them, which are put right by up to two pixels after.
    assert (columns < 318).sum() <= 200
    assert (columns > 322).sum() <= 200


def test_a_keyframe_is_taken_where_the_settings_say():
    moved = exp_se3(np.array([0, np.radians(15), 0, 0, 0, 0]))
    result = IcpResult(moved, np.eye(6), np.eye(6), 1.0, 1.0, 1.0, 1.0, 100, ColorCalibration.nominal())
    assert needs_keyframe(result, KeyframeSettings())
    assert not needs_keyframe(result, KeyframeSettings(max_angle_deg=20))
    assert needs_keyframe(replace(result, overlap=0.55), KeyframeSettings(max_angle_deg=20, min_score=0.6))


def test_depth_counts_by_the_sensors_noise_and_as_far_as_it_is_used(room):
    z = np.array([0.5, 2.0], np.float32)
    constant = DepthNoise(DepthSettings(sigma_m=0.01, sigma_per_m2=0))
    np.testing.assert_allclose(constant.at_rest(z), 0.01)
    np.testing.assert_allclose(DepthNoise(DepthSettings()).at_rest(z), [0.001219, 0.006064], rtol=1e-3)
    config = SlamConfig(depth=DepthSettings(max_depth_m=2.0))
    features = FeatureExtractor(config).extract(room[10], ColorCalibration.nominal())
    near, far = (View.of(room[10], features, STILL, settings).pyramid for settings in (config, SlamConfig()))
    assert near.levels[-1].points[2].max() <= 2.0 < far.levels[-1].points[2].max()
    assert near.n_points < far.n_points


def test_patience_decides_how_many_unknown_frames_begin_a_submap(room):
    for patience, submaps in ((0, {0, 1}), (2, {0})):
        slam = SlamSystem(SlamConfig(submaps={"patience_frames": patience, "resume_frames": 0}))
        for index, source in enumerate((0, 1, 2, 45, 46)):
            slam.locate(replace(room[source], index=index, stamp=index / 30, world_from_camera=None))
        assert {keyframe.submap for keyframe in slam.keyframes.all} == submaps
