"""Settings of the pose estimation on the command line, in files, and on their way to it."""

from __future__ import annotations

import pytest

from app.pipeline.prepare_run import poses_of
from app.settings.config_file import read_config
from app.settings.run_config import RunConfig
from razer.errors import BadInput
from razer.storage.settings_list import list_settings
from razer.storage.toml_text import toml_text
from slam.config import SlamConfig
from slam.poses import GivenPoses


def test_sections_within_a_section_come_back_from_toml(tmp_path):
    config = read_config(None, ["slam.loop_closure.max_distance_m=2.5", "slam.color.rolling_shutter=false"], {})
    assert (config.slam.loop_closure.max_distance_m, config.slam.color.rolling_shutter) == (2.5, False)
    assert config.slam != SlamConfig()
    file = tmp_path / "config.toml"
    file.write_text(toml_text(list_settings(config)), encoding="utf-8")
    assert "[slam.loop_closure]" in file.read_text(encoding="utf-8")
    assert read_config(file, [], {}) == config


def test_settings_of_the_pose_estimation_are_listed_and_wrong_ones_named():
    by_name = {setting.name: setting for setting in list_settings(RunConfig())}
    assert by_name["slam.keyframes.max_angle_deg"].allowed == "> 0 and <= 90"
    with pytest.raises(BadInput, match=r"slam\.loop_closure\.max_distance_m"):
        read_config(None, ["slam.loop_closure.max_distance=2"], {})
    with pytest.raises(BadInput, match=r"slam\.keyframes\.max_shift_m = 0"):
        read_config(None, ["slam.keyframes.max_shift_m=0"], {})


def test_they_reach_the_pose_estimation_of_a_run():
    config = read_config(None, ["slam.keyframes.max_shift_m=0.1"], {"input.poses": "slam"})
    assert poses_of(config)().config == config.slam
    assert isinstance(poses_of(read_config(None, [], {"input.poses": "given"}))(), GivenPoses)
