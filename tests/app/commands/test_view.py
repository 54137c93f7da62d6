"""`razer view` from the outside."""

from __future__ import annotations

from app.timeline import viewer
from tests.support.cli import razer


def test_view_opens_the_timeline_of_a_run(capsys, monkeypatch, tmp_path):
    opened = []
    monkeypatch.setattr(viewer, "open_viewer", lambda path, web: opened.append((path, web)))
    (tmp_path / "timeline.rrd").write_bytes(b"")
    assert razer(capsys, "view", tmp_path, "--web")[0] == 0
    assert opened == [(tmp_path / "timeline.rrd", True)]


def test_view_without_a_timeline_is_bad_input(capsys, tmp_path):
    code, _, err = razer(capsys, "view", tmp_path)
    assert code == 2
    assert "timeline.rrd does not exist" in err
