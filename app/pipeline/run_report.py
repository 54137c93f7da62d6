"""Report of a finished run: tables for people, one line of JSON for programs."""

from __future__ import annotations

from collections import Counter
from json import dumps
from pathlib import Path
from typing import Any

from rich.console import Console
from rich.table import Table

from app.console.outputs import print_outputs
from app.console.streams import result_console
from app.frames.cameras.color_registration import ColorRegistration
from app.frames.frame_account import FrameAccount
from app.frames.frame_accounting import FrameAccounting
from app.pipeline.open_stretches import print_open
from app.pipeline.run_pipeline import RunResult
from app.run_folder.pose_corrections import PoseCorrections
from app.settings.run_config import RunConfig
from razer.map_object import MapObject
from razer.panoptic_map import PanopticMap

_MAX_ROWS = 20
_MAX_REASONS = 3
_MAX_STAGES = 3


def print_run(result: RunResult, folder: Path, *, as_json: bool) -> None:
    """Print what a run mapped and where it lies: tables, or one line of JSON (format 1)."""
    accounting, panoptic, timings = result.accounting, result.panoptic, result.timings
    if as_json:
        content = run_json(folder, accounting, len(panoptic.objects), timings) | {"parts": len(panoptic.parts)}
        content |= {} if (moved := _corrections(result)) is None else {"corrected": moved.as_json()}
        print(dumps(content | _rgbd_json(result.registration) | _models_json(result.config)))
        return
    console = result_console()
    print_instances(panoptic, console)
    print_speed(timings, console)
    print_frames(accounting, console)
    _print_cuts(timings, console)
    if (moved := _corrections(result)) is not None:
        console.print(moved.describe(), soft_wrap=True, highlight=False)
    print_outputs(folder, console=console)


def _corrections(result: RunResult) -> PoseCorrections | None:
    """What was corrected of given poses, None where these were not to be."""
    if result.config.input.poses != "refine":
        return None
    return PoseCorrections.of(result.accounting.given, result.accounting.by_index())


def run_json(folder: Path, accounting: FrameAccounting, n_instances: int, timings: dict[str, Any]) -> dict[str, Any]:
    """The last line of `razer run --json` (format 1).

    Args:
        folder: the run folder.
        accounting: what became of the frames.
        n_instances: how many instances the map has.
        timings: the contents of timings.json.
    """
    return {
        "format": 1,
        "run": str(folder),
        **accounting.account().as_json(),
        "instances": n_instances,
        "timings": timings,
    }


def _rgbd_json(registration: ColorRegistration) -> dict[str, Any]:
    """`rgbd`: the estimate of the colour camera, null where none was made; `rgbd_applied`: whether colour was brought
    onto depth."""
    content = registration.to_json()
    return {"rgbd": content["rgbd"], "rgbd_applied": content["applied"]}


def _models_json(config: RunConfig) -> dict[str, Any]:
    """`segmenter` and `embedder`: the name, and `asked`, "auto" where that was asked for, else null."""
    return {
        "segmenter": {"name": config.segmenter.name, "asked": config.segmenter.asked},
        "embedder": {"name": config.embedder.name, "asked": config.embedder.asked},
    }


def print_instances(panoptic: PanopticMap, console: Console) -> None:
    """A table of the largest instances."""
    largest = sorted(panoptic.objects, key=lambda item: item.n_voxels, reverse=True)
    table = Table(title=f"{len(largest)} instances", title_justify="left")
    table.add_column("id", justify="right")
    table.add_column("class")
    for name in ("size, m", "centre, m", "seen in", "score"):
        table.add_column(name, justify="right")
    for item in largest[:_MAX_ROWS]:
        table.add_row(*_row(item))
    console.print(table)
    if len(largest) > _MAX_ROWS:
        console.print(f"and {len(largest) - _MAX_ROWS} smaller ones")
    if surfaces := [f"{item.class_name or '-'} {item.id}" for item in largest if item.is_stuff]:
        console.print(f"surfaces among them (stuff): {', '.join(surfaces[:_MAX_ROWS])}", soft_wrap=True)
    if panoptic.parts:
        n_wholes = len({part.part_of for part in panoptic.parts})
        console.print(f"{len(panoptic.parts)} parts of {n_wholes} instances")


def _row(item: MapObject) -> tuple[str, ...]:
    size = " x ".join(f"{edge:.2f}" for edge in sorted(item.box.extent, reverse=True))
    centre = " ".join(f"{value:6.2f}" for value in item.box.center)
    return str(item.id), item.class_name or "-", size, centre, str(item.observations), f"{item.score:.2f}"


def print_frames(accounting: FrameAccounting, console: Console) -> None:
    """How many frames were used, and why the others were not; repairs by the reader are counted."""
    account = accounting.account()
    console.print(account.describe())
    _print_lost(accounting, account, console)
    if accounting.graph is not None:
        print_open(accounting.graph.open, console)
    for entry in accounting.skipped[:_MAX_REASONS]:
        console.print(f"  frame {entry.frame}: {entry.reason}", soft_wrap=True)
    if len(accounting.skipped) > _MAX_REASONS:
        console.print(f"  and {len(accounting.skipped) - _MAX_REASONS} more")
    _print_notes(accounting.notes, console)
    if accounting.pose_note:
        console.print(f"  {accounting.pose_note}", soft_wrap=True, highlight=False)


def _print_cuts(timings: dict[str, Any], console: Console) -> None:
    """Whether the run was ended early, and where it went on after it had been cut off."""
    if timings["interrupted"]:
        console.print("ended early: the map holds what was mapped until then")
    if timings["resumed_at"]:
        console.print(f"resumed after frame {', '.join(map(str, timings['resumed_at']))} of those asked for")


def _print_lost(accounting: FrameAccounting, account: FrameAccount, console: Console) -> None:
    intervals = account.lost_intervals or ()
    for first, last in intervals[:_MAX_REASONS]:
        frames = f"frame {first}" if first == last else f"frames {first} to {last}"
        console.print(f"  {frames}: the camera could not be located", soft_wrap=True)
    if len(intervals) > _MAX_REASONS:
        console.print(f"  and {len(intervals) - _MAX_REASONS} more times")
    if accounting.graph is not None and accounting.graph.n_unanchored:
        console.print(
            "  some of them were located among themselves, but no view connects them with the map: "
            "let the camera see the way between both places",
            soft_wrap=True,
        )


def _print_notes(notes: Counter[str], console: Console) -> None:
    for note, count in notes.most_common(_MAX_REASONS):
        console.print(f"  {count} {'frame' if count == 1 else 'frames'}: {note}", soft_wrap=True)


def print_speed(timings: dict[str, Any], console: Console) -> None:
    """Frames a second, what takes most of the time, and peak memory."""
    stages = timings["stages"]
    busy_s = sum(stage["total_s"] for stage in stages.values()) or 1.0
    slowest = sorted(stages, key=lambda name: -stages[name]["total_s"])[:_MAX_STAGES]
    shares = ", ".join(f"{name} {stages[name]['total_s'] / busy_s:.0%}" for name in slowest)
    of_device = max(timings["device_mb_at_tenths"])
    taken = f"; {of_device:.0f} MB of {timings['device']} taken" if of_device else ""
    console.print(
        f"{timings['fps']:.1f} frames/s, {timings['wall_s']:.1f} s, most of it {shares}; "
        f"peak {timings['peak_rss_mb']:.0f} MB{taken}",
        soft_wrap=True,
    )
    if "rebuilding" in timings:
        rebuilding = timings["rebuilding"]
        often = "once" if rebuilding["rebuilds"] == 1 else f"{rebuilding['rebuilds']} times"
        console.print(
            f"the map was rebuilt {often} at corrected poses: {rebuilding['share']:.0%} of the time", soft_wrap=True
        )
