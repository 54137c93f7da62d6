"""`razer inspect`: what a recording is, and what is likely wrong with it, before an hour is spent on mapping it."""

from __future__ import annotations

from dataclasses import asdict
from json import dumps
from pathlib import Path
from typing import TYPE_CHECKING, Any

from app.console.streams import result_console
from app.settings.options import Flag, SourceOptions

if TYPE_CHECKING:
    from data_tools.checks.inspection import Inspection

FORMAT = 1
NOTHING_USABLE = 2
MOST_NAMED = 3


def inspect(
    folder: Path,
    /,
    *,
    options: SourceOptions = SourceOptions(),  # noqa: B008
    json: Flag = False,
) -> int:
    """Say what a recording is: layout, frames, rate, poses, depth; and try whether poses, depth and colour fit.

    Each likely mistake is named with its fix. The exit code is 2 only if no frame can be used.

    Parameters
    ----------
    folder:
        The recording; its layout is recognised.
    json:
        One line of JSON.
    """
    # Late, since OpenCV and SciPy take a moment to load: help and wrong usage should not wait for them.
    from app.frames.open_recording import open_unchecked
    from data_tools.checks.inspection import inspect_sequence
    from data_tools.registry import recognise

    settings = options.input_settings()
    found = inspect_sequence(open_unchecked(folder, settings))
    layout = settings.reader or recognise(folder)
    if json:
        print(dumps(inspect_json(folder, layout, found)))
    else:
        _report(layout, found)
    return NOTHING_USABLE if len(found.bad) == found.inspected else 0


def inspect_json(folder: Path, layout: str, found: Inspection) -> dict[str, Any]:
    """The line of `razer inspect --json` (format 1); what is not known is null."""
    poses, alignment = found.poses, found.rgbd_alignment
    return {
        "format": FORMAT,
        "folder": str(folder),
        "layout": layout,
        "frames": found.n_frames,
        "intrinsics": asdict(found.intrinsics),
        "rate_hz": found.rate_hz,
        "duration_s": found.duration_s,
        "looked": found.inspected,
        "bad": [{"frame": index, "reason": reason} for index, reason in found.bad],
        "poses": {
            "share": found.posed / max(found.inspected, 1),
            "path_m": found.path_m,
            "pairs": poses.n_pairs,
            "agreement": poses.agreement[0] if poses.n_pairs else None,
        },
        "depth": None if found.depth is None else asdict(found.depth),
        "depth_scale": asdict(found.depth_scale),
        "registration": asdict(alignment) | {"text": str(alignment)},
        "findings": [asdict(issue) for issue in found.issues],
    }


def _report(layout: str, found: Inspection) -> None:
    console = result_console()
    for name, value in _lines(layout, found):
        console.print(f"{name + ':':14}{value}", soft_wrap=True)
    for index, reason in found.bad[:MOST_NAMED]:
        console.print(f"  frame {index}: {reason}", soft_wrap=True)
    for issue in found.issues:
        console.print(f"LIKELY WRONG, {issue.about}: {issue.problem}", style="bold red", soft_wrap=True)
        console.print(f"  fix: {issue.fix}", style="bold", soft_wrap=True)
    if not found.issues:
        console.print("nothing looks wrong")


def _lines(layout: str, found: Inspection) -> list[tuple[str, str]]:
    """The facts, name and text."""
    camera, depth, poses = found.intrinsics, found.depth, found.poses
    rate = f", {found.rate_hz:.1f} a second" if found.rate_hz else ""
    lasting = f", {found.duration_s:.1f} s" if found.duration_s else ""
    lines = [
        ("layout", layout),
        ("frames", f"{found.n_frames}{rate}{lasting}"),
        ("camera", f"{camera.width}x{camera.height}, focal lengths {camera.fx:.1f} {camera.fy:.1f}, "
                   f"centre {camera.cx:.1f} {camera.cy:.1f}"),
        ("looked at", f"{found.inspected} frames, {len(found.bad)} cannot be used"),
        ("poses", _poses_text(found)),
    ]  # fmt: skip
    if depth is not None:
        text = (
            f"{depth.low_m:.2f} to {depth.high_m:.2f} m, median {depth.median_m:.2f} m, {depth.valid:.0%} of the image"
        )
        lines.append(("depth", text))
    scale = found.depth_scale
    lines.append(("depth scale", f"{scale.declared:g} units per metre: {scale.reason}"))
    if poses.n_pairs:
        text = f"{poses.agreement[0]:.0%} of the depth agrees over {poses.n_pairs} pairs of frames"
        lines.append(("reprojection", text))
    lines.append(("registration", str(found.rgbd_alignment)))
    return lines


def _poses_text(found: Inspection) -> str:
    if not found.posed:
        return "none"
    return f"{found.posed} of {found.inspected} frames, {found.path_m or 0:.1f} m along them"
