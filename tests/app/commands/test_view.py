"""`razer view` from the outside."""

from __future__ import annotations

import pytest

from app.timeline.viewer import rerun_viewer
from tests.support.cli import razer


def test_view_opens_the_timeline_of_a_run(capsys, monkeypatch, tmp_path):
    opened = []
    monkeypatch.setattr(rerun_viewer, "open_viewer", lambda run, web: opened.append((run, web)))
    assert razer(capsys, "view", tmp_path, "--web")[0] == 0
    assert opened == [(tmp_path, True)]


def test_view_without_a_timeline_is_bad_input(capsys, tmp_path):
    code, _, err = razer(capsys, "view", tmp_path)
    assert code == 2
    assert "has no timeline" in err


@pytest.mark.parametrize("options", [(), ("other",)])
def test_view_without_a_display_says_what_to_do_in_one_line(capsys, monkeypatch, tmp_path, options):
    for name in rerun_viewer.DISPLAYS:
        monkeypatch.delenv(name, raising=False)
    (tmp_path / "timeline.rrd").write_bytes(b"")
    code, _, err = razer(capsys, "view", tmp_path, *options)
    assert code == 2
    assert err.count("\n") == 1
    assert "razer view --web" in err


def test_runs_without_a_timeline_are_not_shown_side_by_side(capsys, tmp_path):
    code, _, err = razer(capsys, "view", tmp_path / "a", tmp_path / "b", "--web")
    assert code == 2
    assert "timeline.rrd does not exist" in err
