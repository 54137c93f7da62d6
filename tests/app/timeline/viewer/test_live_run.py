"""A run that is watched: whatever becomes of the viewer, the run goes on and leaves everything."""

from __future__ import annotations

import os
import re
import signal
import socket
import subprocess
import sys
import time
from urllib.parse import urlsplit
from urllib.request import urlopen

import psutil
import pytest

from app.timeline.recording.saved_recording import SavedRecording
from app.timeline.viewer.free_port import HOST, free_port
from app.timeline.viewer.rerun_process import rerun_environment
from app.timeline.viewer.rerun_viewer import server_command
from tests.support.cli import QUICK, RUN_FILES, write_small_room

pytestmark = pytest.mark.full
WAIT_S = 120


@pytest.fixture
def watched(tmp_path):
    """A run that is going on, its page's address, and its folder."""
    write_small_room(tmp_path / "room", n_frames=40)
    command = [sys.executable, "-m", "app", "run", str(tmp_path / "room"), "-o", str(tmp_path / "run"), *QUICK]
    command += ["--segmenter", "geometric", "--embedder", "appearance", "--view", "web"]
    run = subprocess.Popen(command, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True)
    said = iter(run.stderr.readline, "")
    url = next(found[0] for line in said if (found := re.search(r"http://\S+", line)))
    server = next(p for p in psutil.Process(run.pid).children() if "app.timeline.viewer.page_server" in p.cmdline())
    try:
        yield run, url, server, tmp_path / "run"
    finally:
        for process in (run, server):
            if process.poll() is None if process is run else process.is_running():
                process.kill()


def finished(run, folder):
    """Wait for the end of a run, and check that nothing is missing."""
    run.communicate(timeout=WAIT_S)
    assert run.returncode == 0
    assert {path.name for path in folder.iterdir()} == RUN_FILES
    assert SavedRecording(folder / "timeline.rrd").holds("map/surface")
    assert list(folder.parent.glob(".run.partial-*")) == []


def until_listening(url):
    for _ in range(10 * WAIT_S):
        with socket.socket() as probe:
            if probe.connect_ex((urlsplit(url).hostname, urlsplit(url).port)) == 0:
                return
        time.sleep(0.1)


def test_the_recording_is_read_from_its_beginning_to_the_end_of_the_run(watched):
    run, url, _, folder = watched
    until_listening(url)
    with urlopen(f"{url}2.rrd", timeout=WAIT_S) as part:
        content = part.read()  # until the run is done with it
    assert content.startswith(b"RRF2")
    finished(run, folder)
    assert f"{url}0.rrd" in urlopen(url).read().decode()  # who comes late sees the finished one


def test_a_killed_viewer_does_not_end_the_run(watched):
    run, _, server, folder = watched
    server.kill()
    finished(run, folder)


def test_a_viewer_that_is_stopped_or_never_reads_does_not_hold_up_the_run(watched):
    run, url, server, folder = watched
    until_listening(url)
    with socket.create_connection((urlsplit(url).hostname, urlsplit(url).port)) as idle:
        idle.sendall(b"GET /2.rrd HTTP/1.0\r\n\r\n")
        os.kill(server.pid, signal.SIGSTOP)
        finished(run, folder)


def test_a_viewer_that_is_frozen_killed_and_opened_anew_shows_everything_from_the_beginning(watched):
    run, url, server, folder = watched
    until_listening(url)
    with socket.create_connection((urlsplit(url).hostname, urlsplit(url).port)) as reader:
        reader.sendall(b"GET /2.rrd HTTP/1.0\r\n\r\n")
        assert reader.recv(1 << 12)
        os.kill(server.pid, signal.SIGSTOP)
        time.sleep(1)
        server.kill()
    assert run.poll() is None  # it goes on
    port = free_port(0)
    again = subprocess.Popen(server_command(folder, port), env=rerun_environment())
    try:
        url = f"http://{HOST}:{port}/"
        until_listening(url)
        with urlopen(f"{url}2.rrd", timeout=WAIT_S) as part:
            assert part.read().startswith(b"RRF2")  # to the end of the run
        finished(run, folder)
        whole = (folder / "timeline.rrd").read_bytes()
        assert urlopen(f"{url}0.rrd", timeout=WAIT_S).read() == whole
    finally:
        again.kill()
        again.wait()
