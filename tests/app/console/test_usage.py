"""Wrong usage is said in the words of the help, in one line with exit code 2."""

from __future__ import annotations

import pytest

from tests.support.cli import razer


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (("query",), "RUN is missing."),
        (("run", "FOLDER"), "--out needs a value."),
        (("run", "FOLDER", "-o"), "-o needs a value."),
        (("run", "FOLDER", "-o", "x", "more"), "too many arguments: 'more'."),
        (("run", "FOLDER", "-o", "x", "-o", "y"), "-o is given more than once."),
        (("run", "FOLDER", "-o", "x", "--stride", "two"), '"two" should be a whole number.'),
        (("run", "FOLDER", "-o", "x", "--depth-scale", "a"), '"a" should be a number.'),
        (("run", "FOLDER", "-o", "x", "--json=3"), '"3" should be true or false.'),
        (("run", "FOLDER", "-o", "x", "--view", "a", "b"), "--view takes 1 at most, not 2."),
        (("eval", "x", "--truth", "y", "--export", "scannet"), "--export needs 2 values, not 1."),
        (("ablate", "--naming"), "--naming needs finished runs"),
        (("config", "--set", "voxels=3"), "voxels = 3: should be a section"),
    ],
)
def test_wrong_usage_is_one_plain_line(arguments, message, capsys):
    code, out, err = razer(capsys, *arguments)
    assert (code, out, len(err.splitlines())) == (2, "", 1)
    assert message in err
    assert not any(word in err for word in ("parameter", "Tokens", "convert", " int", "float", "Settings", "dict"))


@pytest.mark.parametrize(
    ("assignment", "message"),
    [
        ("voxels.voxel_size_m=big", "voxels.voxel_size_m = 'big': should be a number"),
        ("voxels.voxel_size_m.a=3", "voxels.voxel_size_m: should be a number"),
        ("input.stride=1.5", "input.stride = 1.5: should be a whole number"),
        ("run.timeline=perhaps", "run.timeline = 'perhaps': should be true or false"),
        ("segmenter=yolo", "segmenter = 'yolo': should be a section"),
        ("segmenter.name=3", "segmenter.name = 3: should be a text"),
        ("segmenter.options=[1]", "segmenter.options = [1]: should be a section"),
    ],
)
def test_settings_of_a_wrong_kind_are_said_in_plain_words(assignment, message, capsys):
    code, _, err = razer(capsys, "config", "--set", assignment)
    assert code == 2
    assert message in err
    assert not any(word in err for word in ("Settings", "valid", "parse", "interpret", "dictionary"))
