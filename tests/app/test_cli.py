"""The command line itself: help without imports, wrong usage, cores for helper processes."""

from __future__ import annotations

import json
import os
import shlex
import subprocess
import sys
from dataclasses import fields
from typing import get_type_hints

import pytest

from app.cli import app, main
from app.console.streams import print_warnings
from app.profiling.cores import leave_cores_to_helpers
from app.settings.options import RunOptions
from app.settings.run_config import RunConfig
from app.verbs import VERBS
from tests.support.cli import razer, write_small_room


@pytest.mark.parametrize(
    ("cores", "given", "expected"), [(2, None, "1"), (16, None, "14"), (None, None, "1"), (8, "3", "3")]
)
def test_helpers_get_cores_of_their_own(cores, given, expected, monkeypatch):
    monkeypatch.setattr("os.cpu_count", lambda: cores)
    monkeypatch.setenv("OMP_NUM_THREADS", given or "")
    if not given:
        monkeypatch.delenv("OMP_NUM_THREADS")
    leave_cores_to_helpers()
    assert os.environ["OMP_NUM_THREADS"] == expected


def test_help_lists_the_verbs_without_importing_them():
    code = (
        "import sys, app.cli\n"
        "try: app.cli.main(['--help'])\n"
        "except SystemExit: pass\n"
        "heavy = {'numpy', 'torch', 'open3d', 'cv2', 'rerun', 'pydantic', 'app.commands.map.run'} & set(sys.modules)\n"
        "print('imported:', sorted(heavy))"
    )
    shown = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True).stdout
    assert "imported: []" in shown
    for verb in ("run", "view", "config", "bench", "demo"):
        assert f" {verb} " in shown


@pytest.mark.parametrize(
    "arguments",
    [("rn",), ("run",), ("run", "in", "-o", "x", "--poses", "perhaps"), ("run", "in", "-o", "x", "--strid", "2")],
)
def test_wrong_usage_is_exit_2(capsys, arguments):
    code, _, err = razer(capsys, *arguments)
    assert code == 2
    (line,) = err.splitlines()
    assert line.startswith("razer")
    assert line.endswith("--help)")


def test_the_help_groups_verbs_by_what_they_are_for(capsys):
    _, shown, _ = razer(capsys, "--help")
    places = [shown.index(f" {word} ") for word in ("Map", "run", "Ask", "query", "Look", "view", "Measure", "eval")]
    assert places == sorted(places)


@pytest.mark.parametrize("verb", [verb for verbs in VERBS.values() for verb in verbs], ids=lambda verb: verb.name)
def test_the_examples_of_a_verb_are_calls_of_it(verb, capsys):
    _, shown, _ = razer(capsys, verb.name, "--help")
    assert verb.examples
    for example in verb.examples:
        assert " ".join(example.split()) in " ".join(shown.split())
        program, *tokens = shlex.split(example)
        assert program == "razer"
        command, *_ = app.parse_args(tokens, exit_on_error=False, print_error=False)  # raises where it is none
        assert command.__module__ == f"app.commands.{verb.target.partition(':')[0]}"


def test_defaults_that_the_help_shows_are_those_of_the_settings():
    settings = RunConfig()
    shown = {f.name: _shown_default(f.name) for f in fields(RunOptions)}
    told = {name: default for name, default in shown.items() if default}
    assert len(told) > 10
    places = {
        "segmenter": settings.segmenter.name, "embedder": settings.embedder.name, "oracle": "none",
        "device": settings.run.device, "timeline": settings.run.timeline,
        "checkpoint_every": settings.run.checkpoint_every,
    }  # fmt: skip
    words = {"None": {"auto", "detected", "the recording's", "all", "every minute"}, "True": {"--timeline"}}
    for name, default in told.items():
        value = places[name] if name in places else getattr(settings.input, name)
        assert default in words.get(str(value), {str(value)}), name


def _shown_default(name):
    (parameter,) = [m for m in get_type_hints(RunOptions, include_extras=True)[name].__metadata__ if m.group][:1]
    return parameter.show_default


@pytest.mark.full
def test_quiet_leaves_results_and_warnings_alone(capsys, tmp_path):
    loud = razer(capsys, "demo", "-o", tmp_path / "loud", "--frames", 2, "--json")
    quiet = razer(capsys, "demo", "-o", tmp_path / "quiet", "--frames", 2, "--json", "--quiet")
    assert (loud[0], quiet[0]) == (0, 0)
    assert "frames/s" in loud[2]
    assert quiet[2] == ""
    assert json.loads(quiet[1].splitlines()[-1])["frames"] == 2
    print_warnings(["smoke"])
    assert "smoke" in capsys.readouterr().err


def test_ctrl_c_in_a_verb_is_one_line(tmp_path, monkeypatch, capsys):
    def interrupted(*_):
        raise KeyboardInterrupt

    monkeypatch.setattr("data_tools.checks.inspection.inspect_sequence", interrupted)
    with pytest.raises(SystemExit) as ended:
        main(["inspect", str(write_small_room(tmp_path / "room"))])
    assert ended.value.code == 130
    assert capsys.readouterr().err.splitlines()[-1] == "razer: interrupted"
