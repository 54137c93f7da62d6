"""The examples of docs/examples run as they are, each in a process of its own, on a small recording."""

from __future__ import annotations

import re
import subprocess
import sys
from pathlib import Path

import cv2
import numpy as np
import pytest
from rich.console import Console

from app.frames.selection import Selection
from data_tools import write_recording
from data_tools.synthetic.synthetic_room import SyntheticRoom

ROOT = Path(__file__).resolve().parents[2]
EXAMPLES = ROOT / "docs" / "examples"
FORMAT_1 = ROOT / "tests" / "fixtures" / "run_format_1"
MAX_LINES = 40


@pytest.fixture(scope="module")
def recording(tmp_path_factory):
    """The first frames of a walk through the synthetic room."""
    folder = tmp_path_factory.mktemp("examples") / "recording"
    start = Selection.of(SyntheticRoom(0, 120, 320, 240), range(6), Console(quiet=True))
    write_recording(start, folder)
    return folder


def run(name, *arguments, cwd):
    command = [sys.executable, str(EXAMPLES / name), *map(str, arguments)]
    environment = {"PYTHONPATH": str(ROOT), "PATH": "", "HOME": str(cwd)}
    done = subprocess.run(command, capture_output=True, text=True, cwd=cwd, env=environment, check=False)
    assert done.returncode == 0, done.stderr
    return done.stdout


def test_each_example_is_short_and_is_run_here():
    here = Path(__file__).read_text(encoding="utf-8")
    names = sorted(path.name for path in EXAMPLES.glob("*.py"))
    assert len(names) >= 7
    for name in names:
        assert len((EXAMPLES / name).read_text(encoding="utf-8").splitlines()) <= MAX_LINES, name
        assert f'run("{name}"' in here, name


def test_map_a_folder(recording, tmp_path):
    out = run("map_a_folder.py", recording, tmp_path / "out", cwd=tmp_path)
    assert len(out.splitlines()) >= 1
    assert (tmp_path / "out" / "instances.json").is_file()


def test_estimate_poses(recording, tmp_path):
    out = run("estimate_poses.py", recording, cwd=tmp_path)
    lines = out.splitlines()
    assert [line.split()[0] for line in lines] == [str(index) for index in range(6)]  # none is lost
    start = [float(number) for number in re.findall(r"-?\d+\.\d*", lines[0])]
    assert start == [0.0, 0.0, 0.0]  # the first camera is the world


@pytest.mark.full
def test_own_segmenter(recording, tmp_path):
    assert "dark things" in run("own_segmenter.py", recording, cwd=tmp_path)


def test_own_embedder(recording, tmp_path):
    out = run("own_embedder.py", recording, cwd=tmp_path).splitlines()
    assert len(out) == 3
    scores = [float(line.split()[1]) for line in out]
    assert scores == sorted(scores, reverse=True)


def test_own_reader(tmp_path):
    for index in range(3):
        cv2.imwrite(str(tmp_path / f"rgb_{index}.png"), np.zeros((120, 160, 3), np.uint8))
        cv2.imwrite(str(tmp_path / f"depth_{index}.png"), np.full((120, 160), 1000, np.uint16))
    assert run("own_reader.py", tmp_path, cwd=tmp_path) == "3 frames of 160 x 120\n"


def test_query_a_map(tmp_path):
    assert "chair #4" in run("query_a_map.py", FORMAT_1, "a chair", cwd=tmp_path)
    assert run("query_a_map.py", FORMAT_1, "a submarine", cwd=tmp_path) == "not in this map\n"


@pytest.mark.full
def test_map_live(recording, tmp_path):
    assert run("map_live.py", recording, cwd=tmp_path).splitlines()[-1].endswith("things")


def test_the_programs_of_the_page_about_python_are_examples():
    page = (ROOT / "docs" / "python.md").read_text(encoding="utf-8")
    blocks = re.findall(r"`docs/examples/(\w+\.py)`\n\n```python\n(.*?)```", page, re.DOTALL)
    assert len(blocks) == page.count("```python") >= 4
    assert [source for _, source in blocks] == [(EXAMPLES / name).read_text(encoding="utf-8") for name, _ in blocks]
