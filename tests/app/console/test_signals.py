"""Ctrl-C and SIGTERM while modules are imported, and afterwards."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest

from tests.support.cli import write_small_room

IMPORTS = """
import signal, time
from app.console.signals import raise_signals
raise_signals()
import slow_module
assert slow_module.is_whole
try:
    time.sleep(30)
except KeyboardInterrupt:
    print("after the import")
"""


def run_program(folder):
    environment = {name: value for name, value in os.environ.items() if name != "PYTHONSAFEPATH"}
    environment["PYTHONPATH"] = str(Path(__file__).parents[3])
    command = [sys.executable, folder / "program.py"]
    return subprocess.run(command, env=environment, capture_output=True, text=True, timeout=60)


@pytest.mark.parametrize(("name", "code", "said"), [("SIGINT", 0, "after the import\n"), ("SIGTERM", 143, "")])
def test_an_import_is_finished_before_a_signal_ends_the_program(tmp_path, name, code, said):
    (tmp_path / "slow_module.py").write_text(
        f"import signal, time\nsignal.raise_signal(signal.{name})\ntime.sleep(0.2)\nis_whole = True\n"
    )
    (tmp_path / "program.py").write_text(IMPORTS)
    done = run_program(tmp_path)
    assert (done.returncode, done.stdout, done.stderr) == (code, said, "")


def test_a_module_that_is_imported_for_ever_can_be_left(tmp_path):
    (tmp_path / "slow_module.py").write_text("while True:\n    pass\n")
    (tmp_path / "program.py").write_text(
        "import signal\nfrom threading import Timer\nfrom app.console import signals\nsignals._PATIENCE_S = 0.1\n"
        "signals.raise_signals()\nTimer(0.2, signal.raise_signal, (signal.SIGTERM,)).start()\nimport slow_module\n"
    )
    done = run_program(tmp_path)
    assert done.returncode == 143


@pytest.mark.parametrize(("name", "code"), [("SIGINT", 130), ("SIGTERM", 143)])
def test_a_signal_that_a_destructor_swallows_is_raised_once_more(tmp_path, name, code):
    (tmp_path / "program.py").write_text(
        "import signal, sys, time\nfrom app.console.signals import raise_signals\nraise_signals()\n"
        f"class Gone:\n    def __del__(self):\n        signal.raise_signal(signal.{name})\n        int()\n"
        "try:\n    gone = Gone()\n    del gone\n    time.sleep(20)\nexcept KeyboardInterrupt:\n    sys.exit(130)\n"
    )
    done = run_program(tmp_path)
    assert (done.returncode, done.stderr) == (code, "")


def test_other_errors_of_destructors_are_told_as_before(tmp_path):
    (tmp_path / "program.py").write_text(
        "from app.console.signals import raise_signals\nraise_signals()\nraise_signals()\n"
        "class Gone:\n    def __del__(self):\n        raise OSError('told')\ngone = Gone()\ndel gone\n"
    )
    done = run_program(tmp_path)
    assert done.returncode == 0
    assert done.stderr.count("OSError: told") == 1


@pytest.mark.full
def test_ctrl_c_at_any_moment_of_the_start_ends_quietly(tmp_path):
    room = write_small_room(tmp_path / "room")
    command = [sys.executable, "-m", "app", "run", room, "-o", tmp_path / "out"]
    for delay_s in [0.15 + 0.13 * i for i in range(20)]:  # imports take some 2 s on an idle machine
        process = subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
        time.sleep(delay_s)
        process.send_signal(signal.SIGINT)
        _, err = process.communicate(timeout=60)
        assert process.returncode == 130, (delay_s, err)
        assert "Traceback" not in err
        assert err.splitlines()[-1:] in ([], ["razer: interrupted"]) or "left out" in err, delay_s
    assert {path.name for path in tmp_path.iterdir()} <= {"room", "out"}
