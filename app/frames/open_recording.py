"""Opening of a recording, with warnings where its poses or its depth scale look wrong."""

from __future__ import annotations

from pathlib import Path

from rich.console import Console

from app.console.waiting import waiting_for
from app.settings.run_config import InputSettings
from data_tools import open_sequence
from data_tools.recordings.sequence import RgbdSequence


def open_recording(folder: Path, settings: InputSettings, console: Console) -> RgbdSequence:
    """The recording in `folder`; raises BadInput. Poses or depths that look wrong are a warning on `console`."""
    # Late: a recording is also opened unchecked, for a few frames of it at once.
    from data_tools.checks.depth_scale import check_depth_scale
    from data_tools.checks.pose_check import check_poses
    from data_tools.checks.sample import Sample

    with waiting_for("opening the recording", console):
        sequence = open_unchecked(folder, settings)
    with waiting_for("checking its poses and its depth", console):
        sample = Sample.of(sequence)
        poses = check_poses(sample)
        if poses.wrong:
            _warn(f"the poses look wrong: {poses.convention.fix}", console)
            sample = sample.reposed(poses.convention)
        scale = check_depth_scale(sequence, sample)
    if scale.verdict != "ok":
        finding = f"the depth scale of {scale.declared:g} units per metre looks wrong: {scale.reason}"
        _warn(f"{finding}; {scale.advice}", console)
    return sequence


def open_unchecked(folder: Path, settings: InputSettings) -> RgbdSequence:
    """The recording in `folder` as the settings say; raises BadInput."""
    extrinsic = settings.depth_to_color
    return open_sequence(
        folder,
        reader=settings.reader,
        camera=settings.intrinsics,
        depth_scale=settings.depth_scale,
        depth_to_color=None if extrinsic is None else Path(extrinsic),
        trust=settings.trust,
    )


def _warn(problem: str, console: Console) -> None:
    console.print(f"WARNING: {problem}", style="bold red", soft_wrap=True)
