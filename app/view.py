"""`razer view`: a finished run in the Rerun viewer."""

from __future__ import annotations

from pathlib import Path

from app.options import Flag
from app.run_folder import TIMELINE
from app.viewer import open_viewer
from razer.frame import BadInput


def view(run: Path, /, *, web: Flag = False) -> None:
    """Open the timeline of a run in Rerun.

    Parameters
    ----------
    run:
        The folder of a run.
    web:
        In the browser instead of the native viewer.
    """
    timeline = run / TIMELINE
    if not timeline.is_file():
        raise BadInput(f"{timeline} does not exist; give the folder of a run made with --timeline")
    open_viewer(timeline, web)
