"""The command line itself: help without imports, wrong usage, cores for helper processes."""

from __future__ import annotations

import os
import subprocess
import sys

import pytest

from app.profiling.cores import leave_cores_to_helpers
from tests.support.cli import razer


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
    assert "Traceback" not in err
