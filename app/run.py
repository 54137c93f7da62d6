"""`razer run`: a recording becomes a panoptic map."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

from cyclopts import Parameter

from app.consoles import progress_console
from app.options import Flag, RunOptions
from app.running.run_folder import RunFolder

INTERRUPTED = 130


def run(
    folder: Path,
    /,
    *,
    out: Annotated[Path, Parameter(name=["--out", "-o"])],
    options: RunOptions = RunOptions(),  # noqa: B008
    overwrite: Flag = False,
    json: Flag = False,
) -> int:
    """Map a posed RGB-D recording: its surface, the things in it, and where they are.

    Ctrl-C finishes the folder with what was mapped until then; the exit code is 130.

    Parameters
    ----------
    folder:
        The recording; its layout is recognised.
    out:
        The folder to write; it appears when it is complete.
    overwrite:
        Replace an older run at the same place, once the new one is complete.
    json:
        End standard output with one line of JSON; progress goes to standard error in any case.
    """
    target = RunFolder(out, overwrite=overwrite)
    config = options.read()

    # Late, since Open3D and torch take seconds to load: help and wrong usage should not wait for them.
    from app.running.pipeline import run_to_folder
    from app.running.recording import open_recording
    from app.running.report import report

    console = progress_console()
    sequence = open_recording(folder, config.input, console)
    finished = run_to_folder(sequence, config, target, console)
    report(finished, target.final, as_json=json)
    return INTERRUPTED if finished.outcome.interrupted else 0
