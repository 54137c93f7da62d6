"""`razer batch` as it is typed: what cannot be is one line, and libraries that are not there are named."""

from __future__ import annotations

from importlib import util

import pytest

from app.settings import extra_libraries
from tests.support.cli import razer, write_small_room


@pytest.fixture
def rooms(tmp_path):
    write_small_room(tmp_path / "rooms/a", n_frames=2)
    return tmp_path / "rooms"


@pytest.mark.parametrize(
    ("options", "said"),
    [
        (["--workers", "0"], "give at least 1"),
        (["--eval", "none"], "choose from default"),
        (["--cores", "-1"], "give 0 or more"),
        (["--poses", "both"], "two runs"),
        (["--vocabulary", "no-such"], "no-such"),
        (["--set", "voxels.size=1"], "voxels"),
    ],
)
def test_what_cannot_be_is_said_before_anything_is_written(capsys, rooms, tmp_path, options, said):
    code, out, err = razer(capsys, "batch", "run", rooms, "-o", tmp_path / "out", *options)
    assert (code, out) == (2, "")
    assert said in err
    assert not (tmp_path / "out").exists()


@pytest.mark.parametrize(
    ("library", "words", "extra"),
    [("ray", ["--address", "auto"], "razer[cluster]"), ("s3fs", ["-o", "s3://bucket/maps"], "razer[s3]")],
)
def test_an_extra_that_is_not_installed_is_named(capsys, monkeypatch, rooms, tmp_path, library, words, extra):
    real = util.find_spec
    monkeypatch.setattr(extra_libraries, "find_spec", lambda name: None if name == library else real(name))
    target = [] if "-o" in words else ["-o", tmp_path / "out"]
    code, _, err = razer(capsys, "batch", "run", rooms, *target, *words)
    assert code == 2
    assert extra in err


def test_no_recordings_are_one_line(capsys, tmp_path):
    code, _, err = razer(capsys, "batch", "run", tmp_path, "-o", tmp_path / "out")
    assert code == 2
    assert "holds no recording" in err
