"""Settings survive the way through TOML, and a wrong one is named with the nearest right one."""

from __future__ import annotations

import tomllib

import pytest
from hypothesis import given
from hypothesis import strategies as st

from app.settings.config_file import read_config
from app.settings.run_config import RunConfig
from razer.config import VoxelSettings
from razer.errors import BadInput
from razer.storage.settings_list import list_settings
from razer.storage.toml_text import toml_text, toml_value

scalars = st.booleans() | st.integers(-(2**62), 2**62) | st.floats(allow_nan=False) | st.text()
values = st.recursive(scalars, lambda inner: st.lists(inner) | st.dictionaries(st.text(), inner), max_leaves=10)


@given(values)
def test_any_value_comes_back_from_toml(value):
    # Lone surrogates cannot be encoded, in TOML or in any file.
    try:
        repr(value).encode()
    except UnicodeEncodeError:
        return
    assert tomllib.loads(f"value = {toml_value(value)}")["value"] == value


def test_all_settings_come_back_from_toml(tmp_path):
    given_settings = {
        "voxels.voxel_size_m": 0.013,
        "input.intrinsics": "525,525,319.5,239.5",
        "input.max_frames": 7,
        "segmenter.options": {"noise": "full", "drop": 0.15, "path": 'C:\\a "b"'},
        "run.timeline": False,
    }
    config = read_config(None, [], given_settings)
    assert config != RunConfig()
    file = tmp_path / "config.toml"
    file.write_text(toml_text(list_settings(config), "two\nlines"), encoding="utf-8")
    assert read_config(file, [], {}) == config


def test_every_setting_is_listed_with_a_meaning():
    settings = list_settings(RunConfig())
    names = [setting.name for setting in settings]
    assert len(set(names)) == len(names)
    assert {f"voxels.{name}" for name in VoxelSettings.model_fields} <= set(names)
    assert [setting.name for setting in settings if len(setting.meaning) < 10] == []
    by_name = {setting.name: setting for setting in settings}
    assert by_name["voxels.voxel_size_m"].allowed == "> 0.001 and <= 0.2"
    assert by_name["input.poses"].allowed == "given, slam, refine, auto"


def test_later_sources_win(tmp_path):
    file = tmp_path / "a.toml"
    file.write_text("[input]\nstride = 2\nmax_frames = 5\nmax_bad = 0.1\n")
    config = read_config(file, ["input.stride=3", "input.max_frames=6"], {"input.stride": 4, "input.reader": None})
    assert (config.input.stride, config.input.max_frames, config.input.max_bad) == (4, 6, 0.1)


@pytest.mark.parametrize(
    ("text", "value"),
    [
        ("full", "full"),
        ("'full'", "full"),
        ("0.25", 0.25),
        ("3", 3),
        ("true", True),
        ("1,2,3,4", "1,2,3,4"),
        ("[1, 2]", [1, 2]),
    ],
)
def test_values_are_read_as_toml_or_else_as_text(text, value):
    config = read_config(None, [f"segmenter.options.x={text}"], {})
    assert config.segmenter.options == {"x": value}
    assert config.segmenter.name == "auto"


@pytest.mark.parametrize(
    ("assignment", "message"),
    [
        ("voxels.voxelsize_m=0.01", "unknown setting voxels.voxelsize_m; did you mean voxels.voxel_size_m"),
        ("voxel.voxel_size_m=0.01", "unknown setting voxel.voxel_size_m; did you mean voxels.voxel_size_m"),
        ("voxels.voxel_size_m=7", "voxels.voxel_size_m = 7: should be less than or equal to 0.2"),
        ("input.poses=perhaps", "input.poses = 'perhaps': should be 'given', 'slam', 'refine' or 'auto'"),
        ("input.stride=often", "input.stride = 'often'"),
        ("input.stride.deep=1", "input.stride"),
        ("input.start=-1", "input.start = -1: should be greater than or equal to 0"),
        ("input.end=0", "input.end = 0: should be greater than or equal to 1"),
        ("voxels=3", "voxels = 3"),
        ("voxels", "section.key=value"),
        ("=3", "section.key=value"),
    ],
)
def test_a_wrong_setting_is_one_plain_line(assignment, message):
    with pytest.raises(BadInput) as error:
        read_config(None, [assignment], {})
    assert message in str(error.value)
    assert "\n" not in str(error.value)


def test_a_range_of_no_frames_is_one_plain_line():
    with pytest.raises(BadInput) as error:
        read_config(None, ["input.start=7"], {"input.end": 7})
    assert str(error.value) == "setting input.end = 7: should be greater than input.start, 7"


@pytest.mark.parametrize(
    ("content", "message"), [(None, "cannot be read"), (b"a = = b", "not TOML"), (b"a = 1\n\xff", "line 2 is no UTF-8")]
)
def test_a_wrong_file_is_named(tmp_path, content, message):
    file = tmp_path / "a.toml"
    if content is not None:
        file.write_bytes(content)
    with pytest.raises(BadInput, match=message) as error:
        read_config(file, [], {})
    assert str(file) in str(error.value)
