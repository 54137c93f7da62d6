"""`razer run`: a recording becomes a panoptic map."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

from cyclopts import Parameter

from app.pipeline.interrupt import INTERRUPTED
from app.console.streams import progress_console
from app.profiling.cores import leave_cores_to_helpers
from app.run_folder.run_folder import RunFolder
from app.settings.options import BOTH, Flag, RunOptions

if TYPE_CHECKING:
    from app.pipeline.run_pipeline import Finished


def run(
    folder: Path,
    /,
    *,
    out: Annotated[Path, Parameter(name=["--out", "-o"])],
    options: RunOptions = RunOptions(),  # noqa: B008
    overwrite: Flag = False,
    json: Flag = False,
) -> int:
    """Map an RGB-D recording: its surface, the things in it, and where they are.

    Ctrl-C finishes the folder with what was mapped until then; the exit code is 130.

    Parameters
    ----------
    folder:
        The recording; its layout is recognised.
    out:
        The folder to write; it appears when it is complete. With --poses both it holds given, slam and compare.
    overwrite:
        Replace an older run at the same place, once the new one is complete.
    json:
        End standard output with one line of JSON; progress goes to standard error in any case.
    """
    if options.poses == "both":
        return _run_both(folder, out, options, overwrite, json)
    finished, target = _run(folder, out, options, overwrite)

    from app.pipeline.run_report import report

    report(finished, target, as_json=json)
    return INTERRUPTED if finished.outcome.interrupted else 0


def _run(folder: Path, out: Path, options: RunOptions, overwrite: bool) -> tuple[Finished, Path]:
    target = RunFolder(out, overwrite=overwrite)
    config = options.read()

    # Late, since Open3D and torch take seconds to load: help and wrong usage should not wait for them.
    leave_cores_to_helpers()
    from app.frames.open_recording import open_recording
    from app.pipeline.run_pipeline import run_to_folder

    console = progress_console()
    sequence = open_recording(folder, config.input, console)
    noted = config.input.model_copy(update={"folder": str(folder.absolute())})
    return run_to_folder(sequence, config.model_copy(update={"input": noted}), target, console), target.final


def _run_both(folder: Path, out: Path, options: RunOptions, overwrite: bool, json: bool) -> int:
    """One run under given poses, one under estimated ones, and their comparison: OUT/given, OUT/slam, OUT/compare."""
    for name in BOTH:
        RunFolder(out / name, overwrite=overwrite)  # before hours are spent on the first
    for name in BOTH:
        progress_console().print(f"mapping under poses: {name}")
        finished, _ = _run(folder, out / name, replace(options, poses=name), overwrite)
        if finished.outcome.interrupted:
            return INTERRUPTED

    from app.commands.measure.compare import compare
    from data_tools.truth.open_truth import has_truth

    truth = folder if has_truth(folder) else None
    return compare(out / "given", out / "slam", truth=truth, out=out / "compare", json=json)
