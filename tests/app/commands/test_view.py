"""`razer view` from the outside."""

from __future__ import annotations

import cv2
import numpy as np
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


# Pictures


def test_a_picture_has_the_size_angle_and_ground_asked_for(capsys, run, tmp_path):
    path = tmp_path / "map.png"
    options = ("--picture", path, "--size", "320x200", "--angle", "30,50", "--background", "transparent")
    code, out, _ = razer(capsys, "view", run, *options)
    assert code == 0
    assert out.replace("\n", "") == f"picture: {path} (--angle 30,50)"
    picture = cv2.imread(str(path), cv2.IMREAD_UNCHANGED)
    assert picture.shape == (200, 320, 4)
    assert set(np.unique(picture[[0, -1], :, 3])) == {0}
    assert (picture[..., 3] == 255).mean() > 0.2


def test_the_angle_that_is_chosen_can_be_asked_for(capsys, run, tmp_path):
    one, other = tmp_path / "one.png", tmp_path / "other.png"
    _, out, _ = razer(capsys, "view", run, "--picture", one)
    angle = out.split("--angle ")[1].split(")")[0]
    razer(capsys, "view", run, "--picture", other, "--angle", angle)
    assert one.read_bytes() == other.read_bytes()
    razer(capsys, "view", run, "--picture", other, "--angle", "top")
    assert one.read_bytes() != other.read_bytes()


@pytest.mark.full
def test_each_style_is_another_picture(capsys, run, tmp_path):
    drawn = set()
    for style in ("color", "instance", "class", "query"):
        query = ("--query", "couch") if style == "query" else ()
        assert razer(capsys, "view", run, "--picture", tmp_path / "map.png", "--style", style, *query)[0] == 0
        drawn.add((tmp_path / "map.png").read_bytes())
    assert len(drawn) == 4


@pytest.mark.parametrize(
    ("options", "message"),
    [
        (("--angle", "top"), "add --picture"),
        (("--style", "class"), "add --picture"),
        (("--picture", "X.png", "--angle", "up"), "--angle up: give top"),
        (("--picture", "X.png", "--size", "40"), "--size 40: write it as"),
        (("--picture", "X.png", "--size", "40x40"), "from 64 to 8192"),
        (("--picture", "X.png", "--style", "query"), "give both"),
        (("--picture", "X.png", "--style", "class", "--query", "couch"), "give both"),
        (("--picture", "X.txt"), "cannot be written"),
        (("--picture", "NONE/X.png"), "cannot be written"),
        (("--picture", "X.jpg", "--background", "transparent"), "cannot be transparent"),
    ],
)
def test_a_picture_that_cannot_be_is_one_plain_line(capsys, run, tmp_path, options, message):
    filled = [str(tmp_path / o) if o.startswith(("X", "NONE")) else o for o in options]
    code, out, err = razer(capsys, "view", run, *filled)
    assert (code, out) == (2, "")
    assert message in err
    assert err.count("\n") == 1
    assert not list(tmp_path.glob("X*"))
