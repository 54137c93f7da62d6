"""`razer config`: every setting, in three ways."""

from __future__ import annotations

import json
import tomllib

from app.settings.run_config import RunConfig
from tests.support.cli import razer


def test_config_prints_every_setting_in_three_ways(capsys, tmp_path):
    changed = ("--set", "voxels.voxel_size_m=0.013")
    _, text, _ = razer(capsys, "config", *changed)
    assert "voxels.voxel_size_m = 0.013   [> 0.001 and <= 0.2] (changed)" in text
    _, as_json, _ = razer(capsys, "config", *changed, "--json")
    values = {setting["name"]: setting["value"] for setting in json.loads(as_json)}
    assert values["voxels.voxel_size_m"] == 0.013
    assert all(f"{name} = " in text for name in values)
    _, toml, _ = razer(capsys, "config", *changed, "--toml")
    assert tomllib.loads(toml)["voxels"]["voxel_size_m"] == 0.013
    (tmp_path / "a.toml").write_text(toml)
    assert razer(capsys, "config", "--config", tmp_path / "a.toml", "--toml")[1] == toml
    assert set(RunConfig.model_fields) == set(tomllib.loads(toml))


def test_a_settings_file_with_a_former_name_is_one_plain_line(capsys, tmp_path):
    (tmp_path / "old.toml").write_text("[follow]\nevery = 2\n")
    code, out, err = razer(capsys, "config", "--config", tmp_path / "old.toml")
    assert (code, out) == (2, "")
    assert err == "razer: setting follow.every is called reintegration.frames_per_keyframe now\n"
