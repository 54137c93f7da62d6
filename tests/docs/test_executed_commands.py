"""The commands that one copies from a page do what it says: they are executed, page by page, on a small recording."""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
from itertools import pairwise
from pathlib import Path

import pytest
from rich.console import Console

from app.frames.selection import Selection
from data_tools.synthetic.synthetic_room import SyntheticRoom
from data_tools.writers.table import write_recording
from tests.support.cli import QUICK, call
from tests.support.page_commands import PAGES, ROOT, block_lines, words

NETWORK, WEIGHTS = "needs the network", "needs the weights of starter"
EXECUTED = (
    "README",
    "first_recording",
    "no_poses",
    "which_models",
    "compare_poses",
    "python",
    "when_it_goes_wrong",
    "page",
    "pictures",
)
LEFT_OUT = {
    "make demo": NETWORK,
    "pip install 'razer[transformers]'": NETWORK,
    "razer models pull starter": NETWORK,
    "razer run FOLDER -o NAMED --stride 5": WEIGHTS,
    'razer query NAMED "something to sit on"': WEIGHTS,
    'razer query OUT "something to sit on"': WEIGHTS,
    "razer label NAMED --vocabulary coco": WEIGHTS,
    'razer edit NAMED rename 12 "office chair"': WEIGHTS,
    "razer view OUT": "needs a display",
    "razer run FOLDER -o OWN --segmenter my_module:DarkThings": "my_module is the reader's own",
}
# The others go through the program's parser (test_commands.py), and what they do is tried by the verbs' own tests.
PAGES_LEFT_OUT = {
    "edits": "needs instances of these numbers",
    "evaluation": "takes hours, or datasets",
    "queries": "takes hours, or a model of words",
    "server": "serves until Ctrl-C",
    "synthetic": "takes long, or a scan",
    "timeline": "needs a display",
}
HAVE_A_RUN = {"page": "OUT", "pictures": "RUN"}  # what these pages call a finished run
WRITES = ("-o", "--page", "--picture")
N_FRAMES, EVERY, SIZE = 24, 3, (160, 120)


@pytest.fixture(scope="module")
def recording(tmp_path_factory):
    """Neighbouring views of a walk through the synthetic room, with poses and truth: what pages call FOLDER."""
    room = SyntheticRoom(0, 240, *SIZE)
    start = Selection.of(room, range(0, EVERY * N_FRAMES, EVERY), Console(quiet=True))
    folder = tmp_path_factory.mktemp("page") / "FOLDER"
    write_recording(start, folder, truth=room.truth(0.05), lossless=True)
    return folder


@pytest.fixture(scope="module")
def finished_run(recording):
    """The map of that recording with the simulator's masks and names."""
    run = recording.with_name("run")
    assert call("run", recording, "-o", run, "--oracle", "full", "--no-timeline", *QUICK) == 0
    return run


def lines_of(name: str) -> list[str]:
    """The shell lines of a page."""
    (page,) = (page for page in PAGES if page.stem == name)
    return block_lines(page)


def is_left_out(line: str) -> bool:
    return any(words(line) == words(known) for known in LEFT_OUT)


def execute(arguments: list[str]) -> int:
    """The exit code of a line that calls the program, or Python with one of the examples."""
    if Path(arguments[0]).name == "razer":
        return call(*arguments[1:])
    assert arguments[0] == "python", f"this test knows no {arguments[0]}"
    environment = {**os.environ, "PYTHONPATH": str(ROOT)}
    command = [sys.executable, str(ROOT / arguments[1]), *arguments[2:]]
    return subprocess.run(command, env=environment, check=False).returncode


@pytest.mark.full
@pytest.mark.parametrize("name", EXECUTED)
def test_the_commands_of_a_page_work_one_after_the_other(name, recording, tmp_path, monkeypatch, request):
    shutil.copytree(recording, tmp_path / "FOLDER")
    if name in HAVE_A_RUN:
        shutil.copytree(request.getfixturevalue("finished_run"), tmp_path / HAVE_A_RUN[name])
    monkeypatch.chdir(tmp_path)
    for line in lines_of(name):
        if is_left_out(line):
            continue
        arguments = words(line)
        assert execute(arguments) == 0, line
        for option, target in pairwise(arguments):
            assert option not in WRITES or Path(target).exists(), line


def test_each_page_with_commands_is_executed_or_left_out_for_a_reason():
    with_commands = {page.stem for page in PAGES if block_lines(page)}
    assert with_commands == {*EXECUTED, *PAGES_LEFT_OUT}


@pytest.mark.parametrize("name", EXECUTED)
def test_a_page_that_is_executed_has_commands_that_are_not_left_out(name):
    assert any(not is_left_out(line) for line in lines_of(name))


def test_what_is_left_out_is_on_a_page():
    lines = [words(line) for name in EXECUTED for line in lines_of(name)]
    assert [known for known in LEFT_OUT if words(known) not in lines] == []
