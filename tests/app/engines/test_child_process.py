"""Child processes of scenes: measured, ended with their helpers and with whoever started them, held to cores."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import time
from pathlib import Path
from threading import Event, Timer

import pytest

from app.engines.child_process import ChildEnd, run_child, tree_mb

HELPER = """
import subprocess, time
print(subprocess.Popen(["sleep", "60"]).pid, flush=True)
time.sleep(60)
"""
BUSY = """
import os, sys, time
sys.stderr.write("why")
print(os.environ["OMP_NUM_THREADS"], os.getcwd())
kept, end_s = bytearray(200_000_000), time.process_time() + 0.7
while time.process_time() < end_s:
    pass
sys.exit(3)
"""
WORKER = """
import sys
from pathlib import Path
from threading import Event
from app.engines.child_process import run_child
code = "import os, time; print(os.getpid(), flush=True); time.sleep(60)"
command = [sys.executable, "-S", "-c", code]
run_child(command, Path({log!r}), Path({out!r}), folder="/", cores=0, threads=1, stop=Event())
"""
TWO_OF_100_MB = """
import subprocess, sys
kept = bytearray(100_000_000)
code = "kept = bytearray(100_000_000); print(1, flush=True); input()"
command = [sys.executable, "-S", "-c", code]
helper = subprocess.Popen(command, stdin=subprocess.PIPE, stdout=subprocess.PIPE)
helper.stdout.readline()
print(1, flush=True)
input()
"""


def run(tmp_path: Path, code: str, *, stop: Event | None = None, cores: int = 0) -> ChildEnd:
    command = [sys.executable, "-S", "-c", code]
    return run_child(
        command, tmp_path / "log", tmp_path / "out", folder="/", cores=cores, threads=3, stop=stop or Event()
    )


def is_running(pid: int) -> bool:
    try:
        return Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()[0] != "Z"
    except OSError:
        return False


def wait_until_gone(pid: int) -> None:
    deadline = time.monotonic() + 5
    while is_running(pid):
        assert time.monotonic() < deadline
        time.sleep(0.02)


def test_code_words_and_use_are_told(tmp_path):
    end = run(tmp_path, BUSY)
    assert end.code == 3
    assert (tmp_path / "log").read_text() == "why"
    assert (tmp_path / "out").read_text() == "3 /\n"
    assert 0.7 <= end.cpu_s < 5
    assert 200 <= end.peak_mb < 400


def test_a_signal_is_told(tmp_path):
    assert run(tmp_path, "import os, signal; os.kill(os.getpid(), signal.SIGKILL)").code == -9


def test_what_is_stopped_ends_with_its_helpers(tmp_path):
    stop = Event()
    Timer(0.6, stop.set).start()
    assert run(tmp_path, HELPER, stop=stop).code is None
    wait_until_gone(int((tmp_path / "out").read_text()))


def test_a_run_ends_with_the_worker_that_started_it(tmp_path):
    started = WORKER.format(log=str(tmp_path / "log"), out=str(tmp_path / "out"))
    worker = subprocess.Popen(
        [sys.executable, "-c", started], env={**os.environ, "PYTHONPATH": os.pathsep.join(sys.path)}
    )
    try:
        deadline = time.monotonic() + 10
        while not (tmp_path / "out").exists() or not (tmp_path / "out").read_text():
            assert time.monotonic() < deadline
            time.sleep(0.02)
        pid = int((tmp_path / "out").read_text())
        assert is_running(pid)
        worker.send_signal(signal.SIGKILL)
        worker.wait()
        wait_until_gone(pid)
    finally:
        worker.kill()


@pytest.mark.skipif(len(os.sched_getaffinity(0)) < 2, reason="needs two cores")
def test_runs_that_are_held_to_cores_have_different_ones(tmp_path, monkeypatch):
    monkeypatch.setenv("TMPDIR", str(tmp_path))
    code = "import os, time; print(*os.sched_getaffinity(0), flush=True); time.sleep(1)"
    script = Path(run_child.__code__.co_filename).with_name("held_launch.py")
    command = [sys.executable, "-S", str(script), str(os.getpid()), "1", sys.executable, "-S", "-c", code]
    both = [subprocess.Popen(command, stdout=subprocess.PIPE, text=True) for _ in range(2)]
    cores = [process.communicate()[0].split() for process in both]
    assert all(len(own) == 1 for own in cores)
    assert cores[0] != cores[1]


def test_memory_of_helpers_counts():
    with subprocess.Popen(
        [sys.executable, "-S", "-c", TWO_OF_100_MB], stdin=subprocess.PIPE, stdout=subprocess.PIPE
    ) as process:
        process.stdout.readline()
        assert 200 <= tree_mb(process.pid) < 300
        process.stdin.write(b"\n")
        process.stdin.close()
        process.kill()
