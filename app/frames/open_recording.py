"""Opening of a recording, with warnings where its poses or its depth scale look wrong."""

from __future__ import annotations

from pathlib import Path

from rich.console import Console

from app.console.waiting import waiting_for
from app.settings.run_config import InputSettings
from data_tools import open_sequence
from data_tools.recordings.sequence import RgbdSequence
from razer.errors import BadInput
from razer.frame import Intrinsics

MOST_OBLONG = 1.5  # of pixels, the longer side by the shorter; images that were stretched have 4 / 3


def open_recording(folder: Path, settings: InputSettings, console: Console) -> RgbdSequence:
    """The recording in `folder`; raises BadInput. Poses or depths that look wrong are a warning on `console`."""
    # Late: a recording is also opened unchecked, for a few frames of it at once.
    from data_tools.checks.depth_scale import check_depth_scale
    from data_tools.checks.pose_check import NO_CONVENTION, check_poses, convention_fix
    from data_tools.checks.sample import Sample

    sequence = open_noted(folder, settings, console)
    with waiting_for("checking its poses and its depth", console):
        sample = Sample.of(sequence)
        poses = check_poses(sample)
        if poses.wrong:
            _warn(f"the poses look wrong: {convention_fix(poses, sequence)}", console)
            sample = sample.reposed(poses.convention)
        scale = check_depth_scale(sequence, sample)
    if poses.is_unfit and scale.verdict == "ok":
        _warn(f"the poses do not fit the images: {poses.contradiction}; {NO_CONVENTION}", console)
    if scale.verdict != "ok":
        finding = f"the depth scale of {scale.declared:g} units per metre looks wrong: {scale.reason}"
        _warn(f"{finding}; {scale.advice}", console)
    return sequence


def open_unchecked(folder: Path, settings: InputSettings) -> RgbdSequence:
    """The recording in `folder` as the settings say; raises BadInput."""
    extrinsic, elsewhere = settings.depth_to_color, settings.poses_from
    return open_sequence(
        folder,
        reader=settings.reader,
        camera=settings.intrinsics,
        depth_scale=settings.depth_scale,
        depth_to_color=None if extrinsic is None else Path(extrinsic),
        poses_from=None if elsewhere is None else Path(elsewhere),
        trust=settings.trust,
    )


def open_noted(folder: Path, settings: InputSettings, console: Console) -> RgbdSequence:
    """The recording in `folder`, unchecked, where it is said what poses from elsewhere are, and what became of guessed
    intrinsics; raises BadInput."""
    with waiting_for("opening the recording", console):
        sequence = open_unchecked(folder, settings)
    print_poses_note(sequence, console)
    if not settings.guess_intrinsics:
        if doubt := _camera_doubt(sequence.intrinsics):
            _warn(doubt, console)
        return sequence
    from app.frames.cameras.refined_camera import refined

    return refined(sequence, settings, console)


def _camera_doubt(k: Intrinsics) -> str:
    """What no usual camera's intrinsics are, in a plain line; "" for usual ones."""
    if not (0 <= k.cx < k.width and 0 <= k.cy < k.height):
        place = f"{k.cx:g}, {k.cy:g} lies outside of the image of {k.width}x{k.height}"
        return f"the principal point {place}: see --intrinsics"
    if not 1 / MOST_OBLONG <= k.fx / k.fy <= MOST_OBLONG:
        return f"focal lengths of {k.fx:g} and {k.fy:g} pixels make pixels that are no squares: see --intrinsics"
    return ""


def print_poses_note(sequence: RgbdSequence, console: Console) -> None:
    """Say what the poses from elsewhere are that a recording was opened with, if they are."""
    if note := getattr(sequence, "poses_note", ""):
        console.print(note, soft_wrap=True, highlight=False, markup=False)


def require_poses(sequence: RgbdSequence) -> None:
    """Raise BadInput if the sequence has no poses at all."""
    if not sequence.has_poses:
        raise BadInput(
            f"{sequence.name}: no camera poses found; --poses slam estimates them, or add trajectory.txt with "
            "lines 'stamp tx ty tz qx qy qz qw' (world from camera), or name the layout with --reader, or a file of "
            "poses with --poses-from"
        )


def _warn(problem: str, console: Console) -> None:
    console.print(f"WARNING: {problem}", style="bold red", soft_wrap=True)
