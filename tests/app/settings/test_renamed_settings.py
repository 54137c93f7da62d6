"""Settings by their former names: refused with today's name in what a user writes, translated in older run folders."""

from __future__ import annotations

import pytest

from app.settings.config_file import read_config, read_run_config
from app.settings.renamed_settings import RENAMED, with_new_names
from app.settings.run_config import RunConfig
from razer.errors import BadInput
from razer.storage.settings_list import list_settings

DEFAULTS = {setting.name: setting.value for setting in list_settings(RunConfig())}


def former_file(folder, old):
    section, key = old.split(".")
    value = DEFAULTS[RENAMED[old]]
    file = folder / "config.toml"
    file.write_text(f"[{section}]\n{key} = {str(value).lower() if isinstance(value, bool) else repr(value)}\n")
    return file


def test_every_former_name_is_gone_and_every_new_one_exists():
    assert not RENAMED.keys() & DEFAULTS.keys()
    assert set(RENAMED.values()) <= DEFAULTS.keys()


@pytest.mark.parametrize("old", RENAMED)
def test_a_former_name_is_refused_with_the_new_one(tmp_path, old):
    line = f"setting {old} is called {RENAMED[old]} now"
    with pytest.raises(BadInput, match=line):
        read_config(former_file(tmp_path, old), (), {})
    with pytest.raises(BadInput, match=line):
        read_config(None, [f"{old}=1"], {})


@pytest.mark.parametrize("old", RENAMED)
def test_a_run_folder_may_bear_any_former_name(tmp_path, old):
    assert read_run_config(former_file(tmp_path, old)) == read_run_config(None)


def test_values_move_to_the_new_names(tmp_path):
    file = tmp_path / "config.toml"
    file.write_text("[follow]\nevery = 2\ndraft = 9\n[maintenance]\nevery = 7\nmax_misses = 4\n")
    config = read_run_config(file)
    assert config.reintegration.frames_per_keyframe == 2
    assert config.reintegration.keyframe_stride == 9
    assert config.maintenance.interval_frames == 7
    assert config.maintenance.max_misses == 4


def test_under_both_names_the_new_one_counts():
    tree = {"follow": {"every": 2}, "reintegration": {"frames_per_keyframe": 3}}
    assert with_new_names(tree) == {"reintegration": {"frames_per_keyframe": 3}}
    assert tree == {"follow": {"every": 2}, "reintegration": {"frames_per_keyframe": 3}}


def test_settings_that_there_are_no_more_are_left_out_of_sections_within_sections(tmp_path):
    file = tmp_path / "config.toml"
    file.write_text("[slam.loop_closure]\nmin_similarity = 0.2\nshortlist = 5\n")
    assert read_run_config(file).slam.loop_closure.shortlist == 5
    with pytest.raises(BadInput, match=r"min_similarity is gone: see .*min_similarity_sigmas"):
        read_config(file, [], {})


@pytest.mark.parametrize("content", ["follow = 3", "reintegration = 3\n[follow]\nevery = 2", "[follow]\never = 2"])
def test_what_is_no_former_name_is_refused_in_a_run_folder_too(tmp_path, content):
    file = tmp_path / "config.toml"
    file.write_text(content)
    with pytest.raises(BadInput):
        read_run_config(file)


def test_former_names_on_the_command_line_are_refused_for_a_run_folder_too(tmp_path):
    with pytest.raises(BadInput, match=r"reintegration\.frames_per_keyframe now"):
        read_run_config(former_file(tmp_path, "follow.draft"), ["follow.every=2"])
