"""Whole processes for which there is no room: one line, exit code 2, nothing left behind."""

from __future__ import annotations

import resource
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

from tests.support.cli import QUICK, listing, write_small_room

RUN = Path(__file__).resolve().parent.parent / "fixtures" / "run_format_1"
LITTLE_MEMORY = 800 << 20  # a quarter less than the least with which any verb gets by, which threads make uncertain
VERBS = {
    "run": ("run", "{room}", "-o", "{out}", "--embedder", "appearance", *QUICK),
    "track": ("track", "{room}", "-o", "{out}"),
    "convert": ("convert", "{room}", "{out}"),
    "synth": ("synth", "{out}", "--frames", "2"),
    "page": ("view", "{run}", "--page", "{out}.html"),
    "picture": ("view", "{run}", "--picture", "{out}.png"),
    "compare": ("compare", "{run}", "{run}", "-o", "{out}"),
    "query": ("query", "{run}", "chair", "--render", "{out}.png"),
}


@pytest.fixture(scope="module")
def room(tmp_path_factory):
    return write_small_room(tmp_path_factory.mktemp("room") / "room", n_frames=4)


def told(verb: str, room: Path, place: Path, kind: int, limit: int) -> str:
    """The last line of a verb under a limit, which had to be refused and to leave its place as it was."""
    run = shutil.copytree(RUN, place / "run")
    names = {"room": room, "run": run, "out": place / "out"}
    before = listing(place)
    done = subprocess.run(
        [sys.executable, "-m", "app", *(word.format(**names) for word in VERBS[verb])],
        capture_output=True, text=True, check=False, timeout=120,
        preexec_fn=lambda: resource.setrlimit(kind, (limit, limit)),
    )  # fmt: skip
    assert "Traceback" not in done.stderr, done.stderr
    assert done.returncode == 2, done.stderr
    assert listing(place) == before
    return done.stderr.splitlines()[-1]


@pytest.mark.full
@pytest.mark.parametrize("verb", VERBS)
def test_no_room_for_a_byte_is_said_before_the_work(verb, room, tmp_path):
    said = told(verb, room, tmp_path, resource.RLIMIT_FSIZE, 0)
    assert f"{tmp_path}/out" in said
    assert "File too large" in said


@pytest.mark.full
@pytest.mark.parametrize("verb", VERBS)
def test_little_memory_is_one_line(verb, room, tmp_path):
    assert "memory ran out" in told(verb, room, tmp_path, resource.RLIMIT_AS, LITTLE_MEMORY)
