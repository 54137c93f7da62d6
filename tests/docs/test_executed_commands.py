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
from tests.support.cli import call
from tests.support.page_commands import ROOT, block_lines, words

NETWORK, WEIGHTS = "needs the network", "needs the weights of starter"
PAGES = {name: ROOT / "docs" / f"{name}.md" for name in ("first_recording", "no_poses", "compare_poses", "python")}
LEFT_OUT = {
    "pip install 'razer[transformers]'": NETWORK,
    "razer models pull starter": NETWORK,
    "razer run FOLDER -o NAMED --stride 5": WEIGHTS,
    'razer query NAMED "something to sit on"': WEIGHTS,
    "razer label NAMED --vocabulary coco": WEIGHTS,
    'razer edit NAMED rename 12 "office chair"': WEIGHTS,
    "razer view OUT": "needs a display",
    "razer run FOLDER -o OWN --segmenter my_module:DarkThings": "my_module is the reader's own",
}
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


def is_left_out(line: str) -> bool:
    return any(words(line) == words(known) for known in LEFT_OUT)


def execute(arguments: list[str]) -> int:
    """The exit code of a line that calls the program, or Python with one of the examples."""
    if arguments[0] == "razer":
        return call(*arguments[1:])
    assert arguments[0] == "python", f"this test knows no {arguments[0]}"
    environment = {**os.environ, "PYTHONPATH": str(ROOT)}
    command = [sys.executable, str(ROOT / arguments[1]), *arguments[2:]]
    return subprocess.run(command, env=environment, check=False).returncode


@pytest.mark.full
@pytest.mark.parametrize("name", PAGES)
def test_the_commands_of_a_page_work_one_after_the_other(name, recording, tmp_path, monkeypatch):
    shutil.copytree(recording, tmp_path / "FOLDER")
    monkeypatch.chdir(tmp_path)
    executed = [words(line) for line in block_lines(PAGES[name]) if not is_left_out(line)]
    assert executed
    for arguments in executed:
        assert execute(arguments) == 0, arguments
        for option, target in pairwise(arguments):
            assert option not in WRITES or Path(target).exists(), arguments


def test_what_is_left_out_is_on_a_page():
    lines = [words(line) for page in PAGES.values() for line in block_lines(page)]
    assert [known for known in LEFT_OUT if words(known) not in lines] == []


def test_pages_have_commands_that_are_executed():
    for name, page in PAGES.items():
        assert any(not is_left_out(line) for line in block_lines(page)), name
