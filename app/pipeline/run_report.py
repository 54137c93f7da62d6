"""What a run says at its end: a table for people, one line of JSON for programs."""

from __future__ import annotations

from collections import Counter
from json import dumps
from pathlib import Path
from typing import Any

from rich.console import Console
from rich.table import Table

from app.console.streams import result_console
from app.frames.frame_accounting import FrameAccounting
from app.pipeline.run_pipeline import Finished
from razer.map_object import MapObject
from razer.panoptic_map import PanopticMap

_ROWS = 20
_REASONS = 3


def report(finished: Finished, folder: Path, *, as_json: bool) -> None:
    """Print what a run found and where it lies: tables, or one line of JSON (format 1)."""
    outcome, panoptic, timings = finished.outcome, finished.panoptic, finished.timings
    if as_json:
        print(dumps(run_json(folder, outcome, len(panoptic.objects), timings)))
        return
    console = result_console()
    print_instances(panoptic, console)
    print_timings(timings, console)
    print_frames(outcome, console)
    console.print(f"outputs: {folder}", soft_wrap=True)


def run_json(folder: Path, outcome: FrameAccounting, instances: int, timings: dict[str, Any]) -> dict[str, Any]:
    """The last line of `razer run --json` (format 1): counts, skipped frames with reasons, timings."""
    return {
        "format": 1,
        "run": str(folder),
        "frames": outcome.frames,
        "used": outcome.used,
        "skipped": [{"frame": skipped.frame, "reason": skipped.reason} for skipped in outcome.skipped],
        "lost": len(outcome.lost),
        "lost_intervals": [list(run) for run in outcome.lost_runs()],
        "instances": instances,
        "timings": timings,
    }


def print_instances(panoptic: PanopticMap, console: Console) -> None:
    """A table of the largest instances."""
    largest = sorted(panoptic.objects, key=lambda item: item.n_voxels, reverse=True)
    table = Table(title=f"{len(largest)} instances", title_justify="left")
    table.add_column("id", justify="right")
    table.add_column("class")
    for name in ("size, m", "centre, m", "seen in", "score"):
        table.add_column(name, justify="right")
    for item in largest[:_ROWS]:
        table.add_row(*_row(item))
    console.print(table)
    if len(largest) > _ROWS:
        console.print(f"and {len(largest) - _ROWS} smaller ones")


def _row(item: MapObject) -> tuple[str, ...]:
    size = " x ".join(f"{edge:.2f}" for edge in sorted(item.box.extent, reverse=True))
    centre = " ".join(f"{value:6.2f}" for value in item.box.center)
    return str(item.id), item.class_name or "-", size, centre, str(item.observations), f"{item.score:.2f}"


def print_frames(outcome: FrameAccounting, console: Console) -> None:
    """How many frames were used, and why the others were not; repairs by the reader are counted."""
    lost = f", {len(outcome.lost)} lost" if outcome.lost else ""
    skipped = f", {len(outcome.skipped)} skipped" if outcome.skipped else ""
    console.print(f"{outcome.used} of {outcome.frames} frames used{lost}{skipped}")
    _print_lost(outcome, console)
    for entry in outcome.skipped[:_REASONS]:
        console.print(f"  frame {entry.frame}: {entry.reason}", soft_wrap=True)
    if len(outcome.skipped) > _REASONS:
        console.print(f"  and {len(outcome.skipped) - _REASONS} more")
    _print_notes(outcome.notes, console)


def _print_lost(outcome: FrameAccounting, console: Console) -> None:
    runs = outcome.lost_runs()
    for first, last in runs[:_REASONS]:
        frames = f"frame {first}" if first == last else f"frames {first} to {last}"
        console.print(f"  {frames}: the camera could not be located", soft_wrap=True)
    if len(runs) > _REASONS:
        console.print(f"  and {len(runs) - _REASONS} more times")
    if outcome.graph is not None and outcome.graph.n_unanchored:
        console.print(
            "  some of them were located among themselves, but no view ties them to the map: "
            "let the camera see the way between both places",
            soft_wrap=True,
        )


def _print_notes(notes: Counter[str], console: Console) -> None:
    for note, count in notes.most_common(_REASONS):
        console.print(f"  {count} times: {note}", soft_wrap=True)


def stage_table(stages: dict[str, dict[str, float]]) -> Table:
    """Median, 95th percentile and share of the time of all stages, for each stage."""
    busy_s = sum(stage["total_s"] for stage in stages.values()) or 1.0
    table = Table()
    table.add_column("stage")
    for name in ("median ms", "p95 ms", "share"):
        table.add_column(name, justify="right")
    for name, stage in stages.items():
        share = f"{100 * stage['total_s'] / busy_s:.0f} %"
        table.add_row(name, f"{stage['median_ms']:.1f}", f"{stage['p95_ms']:.1f}", share)
    return table


def print_timings(timings: dict[str, Any], console: Console) -> None:
    """Frames a second, peak memory, and the median and share of each stage."""
    console.print(f"{timings['fps']:.1f} frames/s, {timings['wall_s']:.1f} s, peak {timings['peak_rss_mb']:.0f} MB")
    console.print(stage_table(timings["stages"]))
    if "rebuilding" in timings:
        console.print(
            "the map followed the poses in {rebuilds} rebuilds: {share:.1%} of the run, longest pause "
            "{longest_pause_s:.2f} s, {kb_per_stored_frame:.0f} KB for each of {stored_frames} stored frames".format(
                **timings["rebuilding"]
            )
        )
