"""Scenes that are evaluated where they are mapped, and pooled, have the numbers of `razer eval --scenes`."""

from __future__ import annotations

import json
import subprocess
import sys
from pathlib import Path

import pytest

from data_tools.synthetic.synthetic_room import SyntheticRoom
from data_tools.writers.table import write_recording
from tests.support.cli import QUICK, environment

ROOMS = {"first": 0, "second": 1}


def call(*words: object) -> str:
    command = [sys.executable, "-m", "app", *map(str, words)]
    done = subprocess.run(command, capture_output=True, text=True, env=environment(), check=False)
    assert done.returncode == 0, done.stderr
    return done.stdout


def as_numbers(evaluation: dict) -> dict:
    """Without what `razer eval` adds of how the frames of each run were used."""
    scenes = {name: {k: v for k, v in one.items() if k != "frames"} for name, one in evaluation["scenes"].items()}
    return evaluation | {"scenes": scenes}


@pytest.mark.full
def test_pooled_scenes_have_the_numbers_of_all_evaluated_together(tmp_path: Path):
    for name, seed in ROOMS.items():
        room = SyntheticRoom(seed, 12, 160, 120)
        write_recording(room, tmp_path / "scans" / name, truth=room.truth(0.05), lossless=True)
    options = ("--segmenter=oracle", "--embedder=oracle", "--no-timeline", *QUICK)
    call("batch", "run", tmp_path / "scans", "-o", tmp_path / "out", *options, "--eval", "default")
    (tmp_path / "list.txt").write_text("\n".join(ROOMS))
    places = ("--runs", tmp_path / "out", "--truth", tmp_path / "scans")
    together = json.loads(call("eval", "--scenes", tmp_path / "list.txt", *places, "--json"))
    pooled = json.loads((tmp_path / "out/evaluation.json").read_text())
    assert pooled["scenes"].keys() == ROOMS.keys()
    assert as_numbers(pooled) == {key: value for key, value in as_numbers(together).items() if key in pooled}
    call("batch", "run", tmp_path / "scans", "-o", tmp_path / "out", *options, "--eval", "default", "--resume")
    assert json.loads((tmp_path / "out/evaluation.json").read_text()) == pooled
    report = json.loads((tmp_path / "out/report.json").read_text())
    assert [entry["attempts"] for entry in report["scenes"]] == [1, 1]
