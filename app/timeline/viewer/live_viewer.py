"""The viewer of a run that is going on. It reads what the run writes to disk, and the run never waits for it: it may be
slow, stopped or killed."""

from __future__ import annotations

import subprocess
from pathlib import Path
from typing import Literal

from app.timeline.viewer.free_port import HOST, PAGE_PORT, free_port
from app.timeline.viewer.rerun_process import rerun_environment
from app.timeline.viewer.rerun_viewer import UNTIL_IDLE, WINDOW, require_display, server_command

ViewerKind = Literal["native", "web"]


def require_viewer(kind: ViewerKind) -> None:
    """Raise BadInput where such a viewer cannot start."""
    if kind == "native":
        require_display()


def open_live(run: Path, kind: ViewerKind) -> str:
    """Start the viewer of the run that is being written to `run`; returns where it is, in words. What serves it ends by
    itself a while after the run; a window stays until it is closed."""
    port = free_port(PAGE_PORT)
    options = [UNTIL_IDLE] if kind == "web" else [UNTIL_IDLE, WINDOW]
    subprocess.Popen(
        server_command(run, port, *options),
        start_new_session=True,  # a Ctrl-C that ends the run leaves it alone
        env=rerun_environment(),
        stdin=subprocess.DEVNULL,
        stdout=subprocess.DEVNULL,
        stderr=subprocess.DEVNULL,
    )
    return f"at http://{HOST}:{port}/" if kind == "web" else "in the viewer's window"
