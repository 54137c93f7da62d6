"""The viewer's processes: the page, what it is served by, and what is said where none can start."""

from __future__ import annotations

import json
import socket
import subprocess
import sys
import time
from contextlib import contextmanager
from urllib.error import HTTPError
from urllib.request import urlopen

import pytest

from app.timeline.viewer import live_viewer, rerun_viewer
from app.timeline.viewer.free_port import HOST, free_port
from app.timeline.viewer.page import page
from app.timeline.viewer.rerun_process import rerun_command, rerun_environment
from razer.errors import BadInput


@contextmanager
def served(run, *options):
    """The address of a page server in a process of its own."""
    port = free_port(0)
    process = subprocess.Popen([*rerun_viewer.server_command(run, port, *options)], env=rerun_environment())
    try:
        for _ in range(300):
            with socket.socket() as probe:
                if probe.connect_ex((HOST, port)) == 0:
                    break
            time.sleep(0.1)
        yield f"http://{HOST}:{port}/"
    finally:
        process.kill()
        process.wait()


def read(url):
    with urlopen(url, timeout=30) as answer:
        return answer.read()


def test_the_page_opens_the_recordings_and_the_server_has_all_that_it_needs(tmp_path):
    run = tmp_path / "my run"
    run.mkdir()
    (run / "timeline.rrd").write_bytes(b"RRF2 and so on")
    with served(run) as url:
        text = read(url).decode()
        assert json.dumps([f"{url}0.rrd"]) in text
        assert "<title>my run</title>" in text
        assert read(f"{url}0.rrd") == b"RRF2 and so on"
        assert read(f"{url}re_viewer_bg.wasm")[:4] == b"\0asm"
        assert b"wasm_bindgen" in read(f"{url}re_viewer.js")
        for missing in ("1.rrd", "../timeline.rrd", "timeline.rrd"):
            with pytest.raises(HTTPError, match="404"):
                read(f"{url}{missing}")


def test_the_page_refers_to_nothing_elsewhere():
    text = page("run", ["http://127.0.0.1:1/0.rrd"])
    assert text.count("http") == 1
    assert "url.origin === location.origin" in text


def test_a_name_of_a_run_is_no_markup():
    assert "<b>" not in page("<b>", [])


def test_rerun_collects_nothing_on_its_use():
    told = subprocess.run(
        rerun_command("analytics", "config"), env=rerun_environment(), capture_output=True, check=True
    )
    assert json.loads(told.stdout)["analytics_enabled"] is False


def test_taken_port_is_replaced():
    with socket.socket() as taken:
        taken.bind((HOST, 0))
        taken.listen()
        port = taken.getsockname()[1]
        assert free_port(port) != port


def test_missing_recording_is_bad_input(tmp_path):
    with pytest.raises(BadInput, match="has no timeline"):
        rerun_viewer.open_viewer(tmp_path, web=True)


@pytest.fixture
def no_display(monkeypatch):
    for name in rerun_viewer.DISPLAYS:
        monkeypatch.delenv(name, raising=False)


@pytest.mark.usefixtures("no_display")
def test_without_a_display_the_way_out_is_said_in_one_line(tmp_path):
    (tmp_path / "timeline.rrd").touch()
    with pytest.raises(BadInput, match="razer view --web"):
        rerun_viewer.open_viewer(tmp_path, web=False)
    with pytest.raises(BadInput, match="no display"):
        live_viewer.require_viewer("native")
    live_viewer.require_viewer("web")


def test_failing_viewer_is_bad_input_and_a_good_one_is_not(tmp_path, monkeypatch):
    (tmp_path / "timeline.rrd").touch()
    commands = []
    monkeypatch.setenv("DISPLAY", ":0")
    monkeypatch.setattr(
        rerun_viewer, "_run_until_stopped", lambda command: commands.append(command) or len(commands) - 1
    )
    rerun_viewer.open_viewer(tmp_path, web=False)
    with pytest.raises(BadInput, match="--web"):
        rerun_viewer.open_viewer(tmp_path, web=False)
    assert commands[0][:3] == [sys.executable, "-m", "rerun_cli"]
    assert rerun_viewer.VIEWER_MEMORY in commands[0]
