"""The end of a verb: its files and what to do next, in words that a shell takes."""

from __future__ import annotations

import shlex
from pathlib import Path

from app import next_steps
from app.console.outputs import print_files, print_next, print_outputs
from app.settings.options import RunOptions, TrackOptions
from app.timeline.viewer.rerun_viewer import DISPLAYS


def test_next_is_a_note_that_a_shell_takes_and_quiet_leaves_out(capsys, monkeypatch):
    print_next(("query", Path("my run"), "a red chair"), ("serve", "x"))
    out, err = capsys.readouterr()
    assert out == ""
    assert shlex.split(err.splitlines()[0]) == ["next:", "razer", "query", "my run", "a red chair"]
    assert err.splitlines()[1] == "      razer serve x"
    monkeypatch.setenv("RAZER_QUIET", "1")
    print_next(("serve", "x"))
    assert capsys.readouterr().err == ""


def test_only_files_that_are_there_are_listed(tmp_path, capsys):
    (tmp_path / "map.npz").touch()
    print_outputs(tmp_path, {"map.npz": "the map", "mesh.ply": "the surface"})
    assert capsys.readouterr().out.splitlines() == [f"outputs in {tmp_path}:", "  map.npz the map"]
    print_outputs(tmp_path, {"mesh.ply": "the surface"})
    assert capsys.readouterr().out == ""


def test_files_of_a_kind_are_counted(tmp_path, capsys):
    for name in (*(f"frame-{number:06d}.png" for number in range(5)), "1.txt", "2.txt", "camera.txt"):
        (tmp_path / name).touch()
    (tmp_path / "depth").mkdir()
    (tmp_path / "depth" / "0.png").touch()
    print_files(tmp_path)
    rows = [line.split() for line in capsys.readouterr().out.splitlines()[1:]]
    assert sorted(rows) == [
        ["1.txt"], ["2.txt"], ["camera.txt"], ["depth/", "1", "files"], ["frame-*.png", "5", "files"],
    ]  # fmt: skip


def test_a_run_goes_where_nothing_is(tmp_path, monkeypatch):
    recording = tmp_path / "lab.sens"
    recording.touch()
    (tmp_path / "here").mkdir()
    monkeypatch.chdir(tmp_path / "here")
    assert next_steps.new_run(recording) == Path("lab_run")
    Path("lab_run").mkdir()
    assert next_steps.new_run(recording) == Path("lab_run2")
    assert next_steps.new_run(recording, beside=True) == tmp_path / "lab_run"


def test_a_run_is_looked_at_by_what_there_is(tmp_path, monkeypatch):
    for name in DISPLAYS:
        monkeypatch.delenv(name, raising=False)
    assert next_steps.looking_at(tmp_path) == ("view", tmp_path, "--page", tmp_path / "map.html")
    (tmp_path / "timeline.rrd").touch()
    assert next_steps.looking_at(tmp_path) == ("view", tmp_path, "--web")
    monkeypatch.setenv(DISPLAYS[0], ":0")
    assert next_steps.looking_at(tmp_path) == ("view", tmp_path)


def test_options_are_said_as_they_were_given():
    given = RunOptions(reader="tum", stride=3, segmenter="yolo", set=("segmenter.options.weights=a b",))
    assert given.words() == (
        "--reader=tum", "--stride=3", "--segmenter=yolo", "--set=segmenter.options.weights=a b",
    )  # fmt: skip
    assert RunOptions().words() == ()
    assert RunOptions(sparse=True).words() == ("--sparse",)
    assert TrackOptions(sparse=False, stride=3).words() == ("--no-sparse", "--stride=3")
