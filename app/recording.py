"""Opens the recording a run is about, and says loudly what looks wrong with it."""

from __future__ import annotations

from pathlib import Path

from rich.console import Console

from app.config import InputSettings
from data_tools.checks.depth_scale import check_depth_scale
from data_tools.sequence import Sequence, open_sequence


def open_recording(folder: Path, settings: InputSettings, console: Console) -> Sequence:
    """The recording in `folder`; raises BadInput. A suspicious depth scale is a warning on `console`."""
    extrinsic = settings.depth_to_color
    sequence = open_sequence(
        folder,
        reader=settings.reader,
        camera=settings.intrinsics,
        depth_scale=settings.depth_scale,
        depth_to_color=None if extrinsic is None else Path(extrinsic),
    )
    _warn_of_depth_scale(sequence, console)
    return sequence


def _warn_of_depth_scale(sequence: Sequence, console: Console) -> None:
    report = check_depth_scale(sequence)
    if report.verdict == "ok":
        return
    fix = f"try --depth-scale {report.likely:g}" if report.likely else "give the right one with --depth-scale"
    console.print(
        f"WARNING: the depth scale of {report.declared:g} units per metre looks wrong: {report.reason}; {fix}",
        style="bold red",
        soft_wrap=True,
    )
