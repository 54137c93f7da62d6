"""`razer inspect`: sanity checks of a recording, before an hour is spent on mapping it."""

from __future__ import annotations

from dataclasses import asdict, replace
from json import dumps
from pathlib import Path
from typing import TYPE_CHECKING, Any

from app.console.outputs import print_next
from app.console.streams import progress_console, result_console
from app.console.waiting import waiting_for
from app.next_steps import mapping
from app.settings.options import Flag, SourceOptions
from razer.errors import BadInput
from razer.storage.atomic_files import replace_content

if TYPE_CHECKING:
    from data_tools.calibration.rgbd_estimate import RgbdEstimate
    from data_tools.checks.inspection import Inspection
    from data_tools.recordings.sequence import RgbdSequence
    from slam.intrinsics.intrinsics_estimate import IntrinsicsEstimate

FORMAT = 1
NOTHING_USABLE = 2
MAX_NAMED = 3
INTRINSICS = "intrinsics"
AFTER_CAMERA = 3  # lines


def inspect(
    folder: Path,
    /,
    *,
    options: SourceOptions = SourceOptions(),  # noqa: B008
    write: Path | None = None,
    json: Flag = False,
) -> int:
    """Check a recording: layout, frames, rate, poses, depth, and whether poses, depth and colour are consistent.

    Each likely fault is named with its fix. The exit code is 2 only if no frame can be used.

    Parameters
    ----------
    folder:
        The recording; its layout is detected.
    write:
        A file for the estimated colour camera, which `razer run --rgbd-calibration` reads.
    json:
        One line of JSON.
    """
    # Late, since OpenCV and SciPy take a moment to load: help and wrong usage should not wait for them.
    with waiting_for("starting"):
        from app.frames.open_recording import open_noted
        from data_tools.checks.inspection import inspect_sequence
        from data_tools.registry import recognise

    settings = options.input_settings()
    with waiting_for("looking at frames all over the recording"):
        as_guessed = settings.model_copy(update={"refine_intrinsics": False})
        sequence = open_noted(folder, as_guessed, progress_console())
        inspection = inspect_sequence(sequence)
    with waiting_for("estimating the intrinsics from pairs of views"):
        inspection, intrinsics = _with_intrinsics(inspection, sequence)
    layout = settings.reader or recognise(folder)
    if write is not None:
        _write_calibration(write, inspection.rgbd_estimate)
    if json:
        print(dumps(inspect_json(folder, layout, inspection, intrinsics)))
    else:
        _report(layout, inspection, intrinsics)
        if write is not None:
            result_console().print(f"output: {write}: the colour camera", soft_wrap=True)
    if len(inspection.bad) == inspection.inspected:
        return NOTHING_USABLE
    if not json:
        print_next(mapping(folder, *options.words(), *_remedies(inspection, options, write)))
    return 0


def _with_intrinsics(inspection: Inspection, sequence: RgbdSequence) -> tuple[Inspection, IntrinsicsEstimate]:
    """The inspection with what pairs of views say of the intrinsics among its findings, and the estimate."""
    from app.frames.cameras.color_registration import ColorRegistration
    from app.frames.cameras.refined_camera import intrinsics_of_views
    from data_tools.checks.inspection import Issue

    color = inspection.rgbd_estimate
    calibration = color.calibration if color.matters else None
    estimate = intrinsics_of_views(sequence, ColorRegistration(inspection.intrinsics, calibration, color))
    if not estimate.contradicts_guess:
        return inspection, estimate
    fix = "--refine-intrinsics takes what the views say; or give the right ones with --intrinsics"
    issue = Issue(INTRINSICS, f"pairs of views fit other ones: {estimate}", fix)
    return replace(inspection, issues=(*inspection.issues, issue)), estimate


def _remedies(inspection: Inspection, options: SourceOptions, calibration: Path | None) -> tuple[object, ...]:
    """Options of `razer run` that go round what is wrong."""
    words: list[object] = []
    if inspection.poses.wrong:
        words += ["--poses", "slam"]
    if inspection.depth_scale.likely is not None and options.depth_scale is None:
        words += ["--depth-scale", f"{inspection.depth_scale.likely:g}"]
    if any(issue.about == INTRINSICS for issue in inspection.issues) and not options.refine_intrinsics:
        words.append("--refine-intrinsics")
    if calibration is not None:
        words += ["--rgbd-calibration", calibration]
    return tuple(words)


def _write_calibration(path: Path, estimate: RgbdEstimate) -> None:
    """The estimated colour camera as a file; raises BadInput where the images do not determine it."""
    if not estimate.confident:
        raise BadInput(f"{path} is not written: {estimate}")
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        replace_content(path, dumps(estimate.calibration.to_json() | {"rgbd": estimate.to_json()}, indent=1) + "\n")
    except OSError as error:
        raise BadInput(f"{path} cannot be written ({error.strerror}): give another file with --write") from None


def inspect_json(folder: Path, layout: str, inspection: Inspection, intrinsics: IntrinsicsEstimate) -> dict[str, Any]:
    """The line of `razer inspect --json` (format 1); what is not known is null."""
    poses, registration = inspection.poses, inspection.rgbd_alignment
    return {
        "format": FORMAT,
        "folder": str(folder),
        "layout": layout,
        "frames": inspection.n_frames,
        "intrinsics": asdict(inspection.intrinsics),
        "intrinsics_estimate": intrinsics.to_json(),
        "rate_hz": inspection.rate_hz,
        "duration_s": inspection.duration_s,
        "looked": inspection.inspected,
        "bad": [{"frame": index, "reason": reason} for index, reason in inspection.bad],
        "poses": {
            "share": inspection.posed / max(inspection.inspected, 1),
            "path_m": inspection.path_m,
            "pairs": poses.n_pairs,
            "agreement": poses.agreement[0] if poses.n_pairs else None,
        },
        "depth": None if inspection.depth is None else asdict(inspection.depth),
        "depth_scale": asdict(inspection.depth_scale),
        "registration": asdict(registration) | {"text": str(registration)},
        "rgbd": inspection.rgbd_estimate.to_json(),
        "findings": [asdict(finding) for finding in inspection.issues],
    }


def _report(layout: str, inspection: Inspection, intrinsics: IntrinsicsEstimate) -> None:
    console = result_console()
    lines = _lines(layout, inspection)
    lines.insert(AFTER_CAMERA, ("intrinsics", str(intrinsics)))
    for name, value in lines:
        console.print(f"{name + ':':15}{value}", soft_wrap=True)
    for index, reason in inspection.bad[:MAX_NAMED]:
        console.print(f"  frame {index}: {reason}", soft_wrap=True)
    for finding in inspection.issues:
        console.print(f"LIKELY WRONG, {finding.about}: {finding.problem}", style="bold red", soft_wrap=True)
        console.print(f"  fix: {finding.fix}", style="bold", soft_wrap=True)
    if not inspection.issues:
        console.print("nothing looks wrong")


def _lines(layout: str, inspection: Inspection) -> list[tuple[str, str]]:
    """The facts, name and text."""
    camera, depth, poses = inspection.intrinsics, inspection.depth, inspection.poses
    rate = f", {inspection.rate_hz:.1f} a second" if inspection.rate_hz else ""
    lasting = f", {inspection.duration_s:.1f} s" if inspection.duration_s else ""
    lines = [
        ("layout", layout),
        ("frames", f"{inspection.n_frames}{rate}{lasting}"),
        ("camera", f"{camera.width}x{camera.height}, focal lengths {camera.fx:.1f} {camera.fy:.1f}, "
                   f"centre {camera.cx:.1f} {camera.cy:.1f}"),
        ("looked at", f"{inspection.inspected} frames, {len(inspection.bad)} cannot be used"),
        ("poses", _poses_text(inspection)),
    ]  # fmt: skip
    if depth is not None:
        text = (
            f"{depth.low_m:.2f} to {depth.high_m:.2f} m, median {depth.median_m:.2f} m, {depth.valid:.0%} of the image"
        )
        lines.append(("depth", text))
    scale = inspection.depth_scale
    lines.append(("depth scale", f"{scale.declared:g} units per metre: {scale.reason}"))
    if poses.n_pairs:
        text = f"{poses.agreement[0]:.0%} of the depth agrees over {poses.n_pairs} pairs of frames"
        lines.append(("reprojection", text))
    estimate = inspection.rgbd_estimate
    lines.append(("registration", str(estimate if estimate.confident else inspection.rgbd_alignment)))
    if not estimate.confident:
        lines.append(("colour camera", str(estimate)))
    return lines


def _poses_text(inspection: Inspection) -> str:
    if not inspection.posed:
        return "none"
    return f"{inspection.posed} of {inspection.inspected} frames, {inspection.path_m or 0:.1f} m along them"
