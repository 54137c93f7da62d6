"""A `razer run` that ends early: killed, interrupted, or by an error nobody knows."""

from __future__ import annotations

import json
import os
import signal
import subprocess
import sys
import time

import numpy as np
import pytest

from tests.support.cli import N_FRAMES, QUICK, RUN_FILES, listing, write_small_room

# A segmenter that finds nothing, logs how often it was called, and takes its time.
SLOW_SEGMENTER = """
import time
from pathlib import Path
from razer.frame import Masks

class Slow:
    def __init__(self, log, wait_s=0.0, fail_at=None):
        self.log, self.wait_s, self.fail_at, self.n_calls = Path(log), wait_s, fail_at, 0

    def segment(self, frame):
        self.n_calls += 1
        self.log.write_text(str(self.n_calls))
        if self.n_calls == self.fail_at:
            raise RuntimeError("a bug in a plug-in")
        time.sleep(self.wait_s)
        return Masks.none(*frame.depth.shape)
"""


@pytest.fixture(scope="module")
def recording(tmp_path_factory):
    return write_small_room(tmp_path_factory.mktemp("recording"))


def start_slow_run(recording, tmp_path, **options):
    """A run in a process of its own whose segmenter is slow; returns the process and its count of frames."""
    (tmp_path / "slow_segmenter.py").write_text(SLOW_SEGMENTER)
    log = tmp_path / "n_calls"
    settings = [f"segmenter.options.{name}={value}" for name, value in {"log": log, **options}.items()]
    command = [sys.executable, "-m", "app", "run", recording, "-o", tmp_path / "runs" / "run", "--json", *QUICK]
    command += ["--segmenter", "slow_segmenter:Slow", *(part for setting in settings for part in ("--set", setting))]
    (tmp_path / "runs").mkdir()
    paths = os.pathsep.join([str(tmp_path), os.environ.get("PYTHONPATH", "")])
    process = subprocess.Popen(
        command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, env={**os.environ, "PYTHONPATH": paths}
    )
    return process, log


def wait_for_frames(process, log, frames):
    while process.poll() is None:
        if log.exists() and int(log.read_text() or 0) >= frames:
            return
        time.sleep(0.02)
    pytest.fail(f"the run ended early: {process.communicate()}")


@pytest.mark.full
def test_a_killed_run_leaves_nothing_under_a_final_name(recording, tmp_path):
    process, log = start_slow_run(recording, tmp_path, wait_s=0.2)
    wait_for_frames(process, log, 3)
    process.kill()
    process.communicate()
    lock, left = sorted((tmp_path / "runs").iterdir())
    assert lock.name == ".run.lock"
    assert left.name.startswith(".run.partial-")


def test_ctrl_c_finishes_the_folder_with_what_is_there(recording, tmp_path):
    process, log = start_slow_run(recording, tmp_path, wait_s=0.2)
    wait_for_frames(process, log, 3 + 3)  # up to three frames are looked at ahead
    process.send_signal(signal.SIGINT)
    out, err = process.communicate()
    assert process.returncode == 130, err
    result = json.loads(out.splitlines()[-1])
    assert 3 <= result["used"] < N_FRAMES
    assert result["frames"] == result["used"] == result["timings"]["frames"]
    assert (result["lost"], result["asked"], result["tracked"]) == (0, N_FRAMES, result["used"] / N_FRAMES)
    run = tmp_path / "runs" / "run"
    assert set(listing(run)) == RUN_FILES
    assert len(np.loadtxt(run / "trajectory.txt")) == result["used"]
    assert len(result["timings"]["rss_mb_at_tenths"]) == 10
    assert [path.name for path in (tmp_path / "runs").iterdir()] == ["run"]


def test_a_run_stopped_before_its_first_frame_leaves_nothing(recording, tmp_path):
    process, log = start_slow_run(recording, tmp_path, wait_s=60)
    wait_for_frames(process, log, 1)
    process.send_signal(signal.SIGINT)
    time.sleep(0.1)  # signals of one kind that arrive together count once
    process.send_signal(signal.SIGINT)
    _, err = process.communicate()
    assert process.returncode == 130
    assert "Traceback" not in err
    assert listing(tmp_path / "runs") == []


@pytest.mark.full
def test_an_unknown_error_keeps_its_traceback_and_leaves_nothing(recording, tmp_path):
    process, _ = start_slow_run(recording, tmp_path, fail_at=2)
    _, err = process.communicate()
    assert process.returncode == 1
    assert "a bug in a plug-in" in err
    assert "Traceback" in err
    assert listing(tmp_path / "runs") == []
