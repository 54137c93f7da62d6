"""The Rerun viewer, native or in a browser, as a process of its own."""

from __future__ import annotations

import os
import signal
import socket
import subprocess
import sys
from pathlib import Path
from urllib.parse import quote

from razer.errors import BadInput

VIEWER_MEMORY = "4GB"
SERVER_MEMORY = "1GB"
HOST = "127.0.0.1"
DATA_PORT, PAGE_PORT = 9876, 9090


def open_viewer(path: Path, web: bool) -> None:
    """Show a recording until the viewer is closed; with `web`, in a browser on this machine, and print where.

    Raises BadInput if there is no such file or the viewer cannot start.
    """
    if not path.is_file():
        raise BadInput(f"{path} does not exist; a run made with --timeline has it")
    command = [sys.executable, "-m", "rerun_cli", str(path), "--memory-limit", VIEWER_MEMORY]
    if web:
        data_port, page_port = _free_port(DATA_PORT), _free_port(PAGE_PORT)
        command += ["--web-viewer", "--bind", HOST, "--server-memory-limit", SERVER_MEMORY]
        command += ["--port", str(data_port), "--web-viewer-port", str(page_port)]
        source = quote(f"rerun+http://{HOST}:{data_port}/proxy", safe="")
        print(f"http://{HOST}:{page_port}/?url={source}\nCtrl-C ends it.", flush=True)
    if _run_until_stopped(command) != 0:
        raise BadInput(f"the viewer could not show {path}; without a screen use `razer view --web`")


def _run_until_stopped(command: list[str]) -> int:
    """Exit status of the command; 0 if a signal to this process ended it, together with all it started."""
    viewer = subprocess.Popen(command, start_new_session=True, env={"RUST_LOG": "warn", **os.environ})
    previous = signal.signal(signal.SIGTERM, _interrupt)
    try:
        return viewer.wait()
    except KeyboardInterrupt:
        return 0
    finally:
        signal.signal(signal.SIGTERM, previous)
        if viewer.poll() is None:
            os.killpg(viewer.pid, signal.SIGTERM)
            viewer.wait()


def _interrupt(*_: object) -> None:
    raise KeyboardInterrupt


def _free_port(preferred: int) -> int:
    """The preferred port, or any other if it is taken."""
    for port in (preferred, 0):
        with socket.socket() as probe:
            try:
                probe.bind((HOST, port))
            except OSError:
                continue
            return int(probe.getsockname()[1])
    raise BadInput(f"no free port on {HOST}: end a program that listens there")
