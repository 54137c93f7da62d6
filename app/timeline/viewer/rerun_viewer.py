"""The viewer of recordings, Rerun's own window or a page in a browser, as a process of its own."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
from collections.abc import Sequence
from pathlib import Path

from app.timeline.recording.live_files import live_parts, recordings_at
from app.timeline.viewer.free_port import HOST, PAGE_PORT, free_port
from app.timeline.viewer.rerun_process import rerun_command, rerun_environment
from razer.errors import BadInput

VIEWER_MEMORY = "4GB"
UNTIL_IDLE, WINDOW = "--until-idle", "--window"  # of the server
DISPLAYS = ("DISPLAY", "WAYLAND_DISPLAY")


def open_viewer(run: Path, web: bool) -> None:
    """Show the timeline of a run, or a recording, until the viewer is closed; with `web`, in a browser on this machine,
    and print where. Raises BadInput if there is none or the viewer cannot start."""
    if not recordings_at(run):
        raise BadInput(f"{run} has no timeline; give the folder of a run made with --timeline, or an .rrd file")
    if web:
        port = free_port(PAGE_PORT)
        print(f"http://{HOST}:{port}/\nCtrl-C ends it.", flush=True)
        command = server_command(run, port)
    else:
        require_display()
        live = live_parts(run)
        command = server_command(run, free_port(0), UNTIL_IDLE, WINDOW) if live else window_command(recordings_at(run))
    if _run_until_stopped(command) != 0:
        raise BadInput(f"the viewer could not show {run}; without a screen use `razer view --web`")


def server_command(run: Path, port: int, *options: str) -> list[str]:
    """The command that serves the page of a run."""
    return [sys.executable, "-m", "app.timeline.viewer.page_server", str(run), str(port), *options]


def window_command(recordings: Sequence[Path | str]) -> list[str]:
    """The command that opens Rerun's window on recordings, given by files or addresses."""
    return rerun_command(*map(str, recordings), "--memory-limit", VIEWER_MEMORY, "--port", "auto")


def require_display() -> None:
    """Raise BadInput where there is no screen to open a window on."""
    if not any(os.environ.get(name) for name in DISPLAYS):
        raise BadInput("there is no display here: `razer view --web` shows it in a browser, --picture draws it")


def _run_until_stopped(command: list[str]) -> int:
    """Exit status of the command; 0 if a signal to this process ended it, together with all it started."""
    viewer = subprocess.Popen(command, start_new_session=True, env=rerun_environment())
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
